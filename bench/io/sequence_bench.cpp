// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Sequences: images per second, raw and compressed, written and read back.
#include <benchmark/benchmark.h>
#include <filesystem>
#include <unistd.h>

#include "io/sequence_writer.hpp"

namespace nav::io {
namespace {

constexpr int kFrames = 40;

std::filesystem::path path_for(bool compressed) {
  return std::filesystem::temp_directory_path() /
         ("sonde_bench_" + std::to_string(::getpid()) + (compressed ? "_z" : "_r") + ".igs.mha");
}

/// Speckle that never repeats, as a compressor meets it in ultrasound.
bool write(bool compressed) {
  SequenceHeader header;
  header.width = 640;
  header.height = 480;
  header.orientation = "MF";
  header.image_type = "BRIGHTNESS";
  header.compressed = compressed;
  auto writer = SequenceWriter::create(path_for(compressed), header);
  if (!writer) return false;
  std::uint32_t state = 1;
  for (int i = 0; i < kFrames; ++i) {
    SequenceImage frame;
    frame.timestamp_s = 0.05 * i;
    frame.image_valid = true;
    frame.pixels.resize(header.frame_bytes());
    for (auto& pixel : frame.pixels) {
      state = state * 1664525u + 1013904223u;
      pixel = static_cast<std::byte>(state >> 27);
    }
    set_transform(frame, {"ProbeToTracker", Eigen::Matrix4d::Identity(), TrackingStatus::kOk});
    if (!writer->append(frame)) return false;
  }
  return writer->finish().has_value();
}

void BM_Write(benchmark::State& state) {
  for (auto _ : state) {
    if (!write(state.range(0) != 0)) state.SkipWithError("the sequence could not be written");
  }
  state.SetItemsProcessed(state.iterations() * kFrames);
  std::filesystem::remove(path_for(state.range(0) != 0));
}
BENCHMARK(BM_Write)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void BM_Read(benchmark::State& state) {
  const bool compressed = state.range(0) != 0;
  if (!write(compressed)) state.SkipWithError("the sequence could not be written");
  for (auto _ : state) {
    auto reader = SequenceReader::open(path_for(compressed));
    for (int i = 0; reader && i < kFrames; ++i) {
      auto frame = reader->read(i);
      if (!frame) state.SkipWithError(frame.error().message.c_str());
      benchmark::DoNotOptimize(frame);
    }
  }
  state.SetItemsProcessed(state.iterations() * kFrames);
  std::filesystem::remove(path_for(compressed));
}
BENCHMARK(BM_Read)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace nav::io
