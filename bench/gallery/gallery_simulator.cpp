// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/gallery/gallery_simulator.hpp"

#include <fstream>
#include <iterator>

#include "app/views/plane_view.hpp"
#include "bench/scene_set.hpp"
#include "io/sequence.hpp"
#include "render/canvas.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/ultrasound.hpp"

namespace nav::bench {
namespace {

constexpr int kPanel = 400;
constexpr int kPanelHeight = 500;
constexpr int kCaption = 28;

/// Rectangle of the ultrasound in a recorded image, and its scale.
struct Crop {
  int x, y, width, height;  ///< Pixels.
  double mm_x, mm_y;        ///< Per pixel.
};

/// A recorded image and the simulated view that comes nearest to it.
struct Comparison {
  std::string name, title;
  std::filesystem::path recording;  ///< Below the data folder.
  int frame;                        ///< Index in a sequence; 0 in a raw file.
  Crop crop;
  std::string family;
  std::size_t view;
  double frequency_mhz;
};

/// Scales from ImageToProbe of the recordings' configurations; of the vessel none is known, it is
/// shown as 45 mm deep.
std::vector<Comparison> comparisons() {
  const std::filesystem::path sequences = "plus-sequences/sequences";
  return {{.name = "simulator-spine",
           .title = "spine phantom",
           .recording = sequences / "SpinePhantomFreehand.igs.mha",
           .frame = 10,
           .crop = {.x = 187, .y = 14, .width = 445, .height = 586, .mm_x = 0.0855, .mm_y = 0.0790},
           .family = "spine",
           .view = 0,
           .frequency_mhz = 6},
          {.name = "simulator-bone",
           .title = "bone under muscle",
           .recording = sequences / "BoneUltrasound_L14.igs.mha",
           .frame = 10,
           .crop = {.x = 176, .y = 2, .width = 466, .height = 612, .mm_x = 0.0854, .mm_y = 0.0854},
           .family = "shoulder",
           .view = 1,
           .frequency_mhz = 10},
          {.name = "simulator-vessel",
           .title = "vessel, scale unknown",
           .recording = "us-predicate/us.raw",
           .frame = 0,
           .crop = {.x = 220, .y = 4, .width = 496, .height = 496, .mm_x = 0.0907, .mm_y = 0.0907},
           .family = "neck",
           .view = 0,
           .frequency_mhz = 9}};
}

Result<Image2d<std::uint8_t>> sequence_image(const std::filesystem::path& file, int frame) {
  auto reader = io::SequenceReader::open(file);
  if (!reader) return reader.error();
  const auto read = reader->read(frame);
  if (!read) return read.error();
  return io::brightness_image(reader->header(), *read);
}

/// 720 x 500 bytes, last row first.
Result<Image2d<std::uint8_t>> raw_image(const std::filesystem::path& file) {
  constexpr int kColumns = 720, kRows = 500;
  std::ifstream in(file, std::ios::binary);
  const std::vector<char> bytes(std::istreambuf_iterator<char>(in), {});
  if (bytes.size() != std::size_t{kColumns} * kRows) {
    return Error{ErrorCode::kMalformedData,
                 file.string() + ": expected 360000 bytes, found " + std::to_string(bytes.size())};
  }
  std::vector<std::uint8_t> pixels(bytes.size());
  for (std::size_t row = 0; row < kRows; ++row) {
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>((kRows - 1 - row) * kColumns), kColumns,
                pixels.begin() + static_cast<std::ptrdiff_t>(row * kColumns));
  }
  return Image2d<std::uint8_t>(kColumns, kRows, std::move(pixels));
}

/// The part of an image that shows ultrasound, with its scale.
Result<UltrasoundImage> cropped(const Image2d<std::uint8_t>& image, const Crop& crop) {
  if (crop.x + crop.width > image.width() || crop.y + crop.height > image.height()) {
    return Error{ErrorCode::kMalformedData,
                 "recorded image: expected 820 x 616 or 720 x 500, "
                 "found " +
                     std::to_string(image.width()) + " x " + std::to_string(image.height())};
  }
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < crop.height; ++y) {
    for (int x = 0; x < crop.width; ++x) pixels.push_back(image.at(crop.x + x, crop.y + y));
  }
  UltrasoundImage frame;
  frame.pixels = {crop.width, crop.height, std::move(pixels)};
  frame.grid = PixelGrid::centred(crop.width, crop.mm_x, crop.mm_y);
  return frame;
}

Result<std::optional<UltrasoundImage>> recorded(const Comparison& c, app::Console& console) {
  const auto file = bench_data_dir() / c.recording;
  if (!std::filesystem::exists(file)) {
    console.report(Severity::kWarning, "gallery",
                   c.name + ": expected " + file.string() + ", found nothing (set SONDE_DATA_DIR)");
    return std::optional<UltrasoundImage>{};
  }
  const auto image = file.extension() == ".raw" ? raw_image(file) : sequence_image(file, c.frame);
  if (!image) return image.error();
  auto frame = cropped(*image, c.crop);
  if (!frame) return frame.error();
  return std::optional(std::move(*frame));
}

/// The recording's width, depth and number of pixels.
sim::ProbeModel probe_like(const Comparison& c, sim::AcousticModel model) {
  sim::ProbeModel probe = sim::linear_l14();
  probe.width_mm = c.crop.width * c.crop.mm_x;
  probe.depth_mm = c.crop.height * c.crop.mm_y;
  probe.focus_mm = 0.45 * probe.depth_mm;
  probe.frequency_mhz = c.frequency_mhz;
  probe.columns = c.crop.width;
  probe.rows = c.crop.height;
  probe.model = model;
  return probe;
}

Result<UltrasoundImage> simulated(const Comparison& c, sim::AcousticModel model) {
  const auto patient = sim::make_patient(c.family, {1, sim::Contrast::kNative});
  if (!patient) return patient.error();
  const sim::UltrasoundSimulator simulator(patient->anatomy, probe_like(c, model), 1);
  return simulator.simulate(patient->views.at(c.view).ct_from_image, Timestamp{}, 0);
}

void draw_panel(render::Canvas& canvas, int column, const std::string& words,
                const std::optional<UltrasoundImage>& frame) {
  const Rgba8 ink = render::rgb8(0xd8dee4);
  canvas.text(column * kPanel + 8, 20, 15, words, ink);
  if (!frame) {
    canvas.text(column * kPanel + 8, 60, 15, "no recording here", ink);
    return;
  }
  app::draw_ultrasound(canvas, app::fit(*frame, column * kPanel, kCaption, kPanel, kPanelHeight),
                       *frame);
}

}  // namespace

std::vector<std::string> simulator_gallery_names() {
  std::vector<std::string> names;
  for (const Comparison& c : comparisons()) names.push_back(c.name);
  return names;
}

Result<void> draw_simulator_gallery(const GalleryOptions& options, app::OutputFolder& folder,
                                    app::Console& console) {
  for (const Comparison& c : comparisons()) {
    if (c.name.find(options.only) == std::string::npos) continue;
    console.begin(c.name);
    const auto real = recorded(c, console);
    if (!real) return real.error();
    render::Canvas canvas(3 * kPanel, kPanelHeight + kCaption, render::rgb8(0x101418));
    draw_panel(canvas, 0, "Recorded: " + c.title, *real);
    int column = 1;
    for (const auto model : {sim::AcousticModel::kRays, sim::AcousticModel::kScatterers}) {
      const auto image = simulated(c, model);
      if (!image) return image.error();
      const bool rays = model == sim::AcousticModel::kRays;
      draw_panel(canvas, column++, std::string("Simulated, ") + (rays ? "rays" : "scatterers"),
                 *image);
    }
    if (auto ok = folder.write_image(c.name + ".png", canvas.image()); !ok) return ok;
    console.end();
  }
  return {};
}

}  // namespace nav::bench
