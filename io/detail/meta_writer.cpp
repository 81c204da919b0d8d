// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/meta_writer.hpp"

#include <bit>
#include <vector>

#include "io/atomic_file.hpp"
#include "io/detail/scratch_file.hpp"
#include "io/detail/text.hpp"

namespace nav::io::detail {
namespace {

std::string meta_header(const VoxelGrid& grid, int channels, const std::string& fields,
                        const std::string& compressed_size) {
  const auto join = [](const auto& values) {
    std::string text;
    for (const auto value : values) {
      text += (text.empty() ? "" : " ") + to_text(static_cast<double>(value));
    }
    return text;
  };
  std::string text = "ObjectType = Image\nNDims = 3\nBinaryData = True\n";
  text += std::string("BinaryDataByteOrderMSB = ") +
          (std::endian::native == std::endian::big ? "True" : "False") + "\n";
  text += compressed_size.empty()
              ? std::string("CompressedData = False\n")
              : "CompressedData = True\nCompressedDataSize = " + compressed_size + "\n";
  // Column-major storage is the order of the format: one direction after another.
  text += "TransformMatrix = " + join(grid.directions.reshaped()) + "\n";
  text += "Offset = " + join(grid.origin_mm) + "\nCenterOfRotation = 0 0 0\n";
  text += "ElementSpacing = " + join(grid.spacing_mm) + "\nDimSize = " + join(grid.size) + "\n";
  if (channels != 1) text += "ElementNumberOfChannels = " + std::to_string(channels) + "\n";
  return text + fields + "ElementType = MET_SHORT\nElementDataFile = LOCAL\n";
}

/// Compresses the whole volume to one zlib stream.
Result<std::vector<std::byte>> deflate_all(std::span<const std::byte> bytes) {
  auto deflater = Deflater::create(DeflateFormat::kZlib);
  if (!deflater) return deflater.error();
  std::vector<std::byte> out;
  const auto collect = [&](std::span<const std::byte> piece) -> Result<void> {
    out.insert(out.end(), piece.begin(), piece.end());
    return {};
  };
  if (const auto ok = deflater->write(bytes, collect); !ok) return ok.error();
  if (const auto ok = deflater->finish(collect); !ok) return ok.error();
  return out;
}

}  // namespace

Result<void> write_meta_image(const VoxelGrid& grid, int channels, const std::string& fields,
                              std::span<const std::byte> bytes, bool compress,
                              const std::filesystem::path& path) {
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  std::vector<std::byte> compressed;
  if (compress) {
    auto deflated = deflate_all(bytes);
    if (!deflated) return deflated.error();
    compressed = std::move(*deflated);
    bytes = compressed;
  }
  const std::string header =
      meta_header(grid, channels, fields, compress ? std::to_string(bytes.size()) : std::string());
  if (const auto ok = file->write(header); !ok) return ok;
  if (const auto ok = file->write(bytes); !ok) return ok;
  return file->commit();
}

}  // namespace nav::io::detail
