// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Recordings of devices: bytes per second, written to memory and read back.
#include <benchmark/benchmark.h>
#include <filesystem>
#include <unistd.h>

#include "io/mcap/device_recorder.hpp"
#include "io/mcap/device_recording.hpp"

namespace nav::io::mcap {
namespace {

constexpr int kImages = 200;
constexpr int kPosesPerImage = 4;

/// A file in memory, so that the disk is not measured.
std::filesystem::path memory_file() {
  const std::filesystem::path folder = std::filesystem::is_directory("/dev/shm")
                                           ? std::filesystem::path("/dev/shm")
                                           : std::filesystem::temp_directory_path();
  return folder / ("sonde_bench_" + std::to_string(::getpid()) + ".mcap");
}

/// The usual image of a scanner, with speckle.
Sample bench_image() {
  constexpr int kWidth = 820, kHeight = 616;
  std::vector<std::uint8_t> pixels(std::size_t{kWidth} * kHeight);
  std::uint32_t state = 1;
  for (auto& pixel : pixels) {
    state = state * 1664525u + 1013904223u;
    pixel = static_cast<std::uint8_t>(state >> 24);
  }
  UltrasoundImage image;
  image.pixels = Image2d<std::uint8_t>(kWidth, kHeight, std::move(pixels));
  image.grid = PixelGrid::centred(kWidth, 0.1, 0.1);
  Sample sample;
  sample.what = std::move(image);
  return sample;
}

/// Records images and poses; returns the bytes of the file, 0 after an error.
std::uint64_t record_bench(const std::filesystem::path& path, const Sample& image) {
  std::filesystem::remove(path);
  auto recorder = DeviceRecorder::create(path);
  if (!recorder || !(*recorder)->add_device("tracker", {{"Probe"}}) ||
      !(*recorder)->add_device("scanner", {{"Image", StreamKind::kImages}})) {
    return 0;
  }
  Sample pose, next = image;
  pose.what = PoseSample{};
  bool ok = true;
  for (int i = 0; i < kImages * kPosesPerImage; ++i) {
    pose.received = next.received = Timestamp(std::chrono::milliseconds(8 * i));
    pose.sequence = next.sequence = static_cast<std::uint64_t>(i);
    ok = ok && (*recorder)->record(0, pose);
    if (i % kPosesPerImage == 0) ok = ok && (*recorder)->record(1, next);
  }
  ok = ok && (*recorder)->finish();
  return ok ? static_cast<std::uint64_t>(std::filesystem::file_size(path)) : 0;
}

void BM_RecordDevices(benchmark::State& state) {
  const auto path = memory_file();
  const Sample image = bench_image();
  std::uint64_t bytes = 0;
  for (auto _ : state) bytes += record_bench(path, image);
  if (bytes == 0) state.SkipWithError("the recording could not be written");
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes));
  std::filesystem::remove(path);
}
BENCHMARK(BM_RecordDevices)->UseRealTime()->Unit(benchmark::kMillisecond);

/// Argument 1: by index, 0: from record to record.
void BM_ReadDevices(benchmark::State& state) {
  const auto path = memory_file();
  const std::uint64_t bytes = record_bench(path, bench_image());
  const bool use_index = state.range(0) != 0;
  std::int64_t samples = 0;
  for (auto _ : state) {
    const auto recording = DeviceRecording::open(path, {false, use_index});
    auto merged = recording ? recording->merged() : Result<MergedRecording>(recording.error());
    while (merged && merged->next()) ++samples;
  }
  if (samples != state.iterations() * kImages * (kPosesPerImage + 1)) {
    state.SkipWithError("the recording could not be read");
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes));
  std::filesystem::remove(path);
}
BENCHMARK(BM_ReadDevices)->Arg(1)->Arg(0)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace nav::io::mcap
