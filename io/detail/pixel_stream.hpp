// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "io/detail/image_file.hpp"
#include "io/detail/input_file.hpp"
#include "io/detail/voxel_sink.hpp"
#include "nav/result.hpp"

namespace nav::io::detail {

/// Decoded samples of an image file as one sequence of bytes, of which only a buffer is in memory.
/// Raw data are read in any order. Compressed data are read forward; an earlier offset starts
/// again. Messages do not name the file: the caller knows it.
class PixelStream {
 public:
  /// \p pipe: the pipe that is a part, already open; null if no part is a pipe.
  static Result<PixelStream> open(const std::vector<DataPart>& parts, Encoding encoding,
                                  std::shared_ptr<const InputFile> pipe = nullptr);
  PixelStream(PixelStream&&) noexcept;
  PixelStream& operator=(PixelStream&&) noexcept;
  ~PixelStream();

  /// Fills \p out completely. kMalformedData when the data end earlier or are damaged.
  Result<void> read(std::int64_t offset, std::span<std::byte> out);
  /// Checks, after everything was read, that the compressed stream ends here, checksum included.
  Result<void> expect_end();
  /// Skips what is left behind \p offset, up to which everything was read. Returns the number of
  /// its bytes, decoded. The compressed stream must have an end, checksum included.
  Result<std::int64_t> skip_to_end(std::int64_t offset);

 private:
  struct Inflater;
  PixelStream();
  /// \p some: may return fewer bytes than asked for, but none only at the end.
  Result<std::size_t> read_raw(std::int64_t offset, std::span<std::byte> out,
                               bool some = false) const;
  Result<std::size_t> inflate(std::span<std::byte> out);
  Result<void> rewind();
  [[nodiscard]] Result<void> check_ended() const;

  struct Part {
    std::shared_ptr<const InputFile> file;
    DataPart place;
  };
  std::vector<Part> parts_;
  std::unique_ptr<Inflater> inflater_;
};

/// Voxels as a file stores them.
struct StoredVoxels {
  std::int64_t offset = 0;  ///< Offset of the first sample, decoded bytes.
  std::size_t count = 0;
  PixelType type = PixelType::kInt16;
  bool swapped = false;  ///< In the other byte order than this machine's.
  Rescale rescale{};
};

/// Passes voxels on, a block at a time. \p stored_bytes: encoded bytes of the file. Of compressed
/// data, which may claim a thousand times their size, memory is reserved as they are decoded.
Result<void> copy_voxels(PixelStream& stream, const StoredVoxels& voxels, std::int64_t stored_bytes,
                         VoxelSink& sink);

/// Reverses the bytes of each sample in place; an incomplete last sample is not changed.
void swap_bytes(std::span<std::byte> bytes, std::size_t sample_size);

}  // namespace nav::io::detail
