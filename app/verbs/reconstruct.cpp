// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/reconstruct.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <future>
#include <sstream>

#include "app/interrupt.hpp"
#include "app/options/overwriting.hpp"
#include "app/report.hpp"
#include "app/verbs/image_confidence.hpp"
#include "io/ct.hpp"
#include "io/plus_config.hpp"
#include "io/scan_line_file.hpp"
#include "nav/stopwatch.hpp"
#include "session/recorded_session.hpp"
#include "tracking/reconstruction/fill_holes.hpp"
#include "tracking/reconstruction/reconstruction.hpp"
#include "tracking/reconstruction/sweep_grid.hpp"

namespace nav::app {
namespace {

using tracking::ImageArea;
using tracking::PlusClip;
using tracking::Reconstruction;
using tracking::VoxelOrigin;

constexpr double kRadians = M_PI / 180;
constexpr double kUsualSpacingMm = 0.5;
/// Memory that a reconstruction may take, bytes.
constexpr double kMostBytes = 8e9;

Error reconstruction_stopped() {
  return {ErrorCode::kCancelled, "reconstruct: stopped; nothing was written"};
}

/// Plays a recording to its end, with its progress under a name.
Result<void> read_all(session::RecordedSession& session, session::Session::Listener& listener,
                      const std::string& name, Console& console, const Interrupt& interrupt) {
  console.begin(name);
  for (bool more = true; more;) {
    const auto stepped = session.step(listener);
    if (!stepped) return stepped.error();
    more = *stepped;
    if (interrupt.asked()) return reconstruction_stopped();
    console.progress(static_cast<double>(session.frames_read()) /
                     static_cast<double>(std::max<std::int64_t>(session.total_images(), 1)));
  }
  console.end();
  return {};
}

Result<std::optional<io::VolumeReconstruction>> reconstruction_of_plus(
    const std::filesystem::path& file) {
  if (file.empty()) return std::optional<io::VolumeReconstruction>();
  const auto plus = io::read_plus_config(file);
  if (!plus) return plus.error();
  return plus->volume_reconstruction;
}

Result<PlusClip> clip_of(const ReconstructOptions& options,
                         const std::optional<io::VolumeReconstruction>& plus) {
  PlusClip clip;
  if (options.clip_px) {
    clip.rectangle = {options.clip_px->head<2>(), options.clip_px->tail<2>()};
  } else if (plus && plus->clip_origin_px && plus->clip_size_px) {
    clip.rectangle = {*plus->clip_origin_px, *plus->clip_size_px};
  }
  if (options.fan) {
    const auto& v = *options.fan;
    clip.fan = {.origin_px = {v[2], v[3]},
                .low_rad = kRadians * v[0],
                .high_rad = kRadians * v[1],
                .radius_start_px = v[4],
                .radius_stop_px = v[5]};
  } else if (plus && plus->fan_angles_deg && !plus->fan_angles_deg->isZero(0) &&
             plus->fan_origin_px && plus->fan_radius_stop_px) {
    const Eigen::Vector2d angles = kRadians * *plus->fan_angles_deg;
    clip.fan = {.origin_px = *plus->fan_origin_px,
                .low_rad = angles.minCoeff(),
                .high_rad = angles.maxCoeff(),
                .radius_start_px = plus->fan_radius_start_px.value_or(0),
                .radius_stop_px = *plus->fan_radius_stop_px};
  }
  if (auto ok = validate(clip); !ok) return ok.error();
  return clip;
}

/// The areas of images, one for each geometry.
class ImageAreas {
 public:
  explicit ImageAreas(const PlusClip& clip) : clip_(clip) {}
  std::shared_ptr<const ImageArea> of(const UltrasoundImage& image) {
    if (!newest_ || !newest_->fits(image)) newest_ = std::make_shared<ImageArea>(image, clip_);
    return newest_;
  }

 private:
  PlusClip clip_;
  std::shared_ptr<const ImageArea> newest_;
};

/// Images that the first reading of a recording found.
struct SurveyedImages {
  /// Geometry of images, and the poses of those that have it, in order.
  struct Group {
    UltrasoundImage geometry;
    std::vector<Transform<frames::Reference, frames::Image>> poses;
  };
  std::vector<Group> groups;
  session::SweepSurvey spread;  ///< About 60 images, to find the sector.
};

Result<SurveyedImages> survey_images(session::RecordedSession& session, bool skip_bad_frames,
                                     const Interrupt& interrupt, Console& console) {
  constexpr std::int64_t kSpread = 60;
  const std::int64_t stride = std::max<std::int64_t>(1, session.total_images() / kSpread);
  if (auto whole = session.check_complete(); !whole) return whole.error();
  SurveyedImages found;
  std::int64_t count = 0;
  session::Session::Listener listener;
  listener.settled = [&](const tracking::PairedImage& paired) {
    if (!paired.tracked) return;
    const UltrasoundImage& image = paired.tracked->frame;
    if (found.groups.empty() ||
        !same_pixels(geometry_of(found.groups.back().geometry), geometry_of(image))) {
      found.groups.push_back({image, {}});
    }
    found.groups.back().poses.push_back(paired.tracked->reference_from_image);
    if (count++ % stride == 0) found.spread.spread.push_back(*paired.tracked);
  };
  if (auto ok = read_all(session, listener, "survey", console, interrupt); !ok) return ok.error();
  if (found.groups.empty()) return session::nothing_paired(session);
  if (auto ok = check_frames(session, skip_bad_frames); !ok) return ok.error();
  return found;
}

struct PlannedVolume {
  VoxelGridIn<frames::Reference> grid;
  tracking::ReconstructionOptions options;
  double bytes = 0;
};

std::string memory_text(double bytes) {
  char text[32];
  std::snprintf(text, sizeof text, bytes < 1e9 ? "%.0f MB" : "%.1f GB",
                bytes < 1e9 ? bytes / 1e6 : bytes / 1e9);
  return text;
}

/// Chooses the grid, and says what it takes. Rejects what takes too much memory.
Result<PlannedVolume> plan_volume(const ReconstructOptions& options, double spacing_mm,
                                  const SurveyedImages& images,
                                  const std::optional<SectorOutline>& sector, const PlusClip& clip,
                                  Console& console) {
  PlannedVolume planned;
  auto& how = planned.options;
  using Method = tracking::ReconstructionMethod;
  how.method = options.method == "trilinear"  ? Method::kTrilinear
               : options.method == "gaussian" ? Method::kGaussian
               : options.method == "backward" ? Method::kBackward
                                              : Method::kNearest;
  using tracking::Compounding;
  how.compounding = options.compound == "median"   ? Compounding::kMedian
                    : options.compound == "max"    ? Compounding::kMaximum
                    : options.compound == "latest" ? Compounding::kLatest
                                                   : Compounding::kMean;
  how.by_confidence = options.weights == "confidence";
  how.gaussian_voxels = options.gaussian_voxels;
  how.reach_mm = options.reach_mm.value_or(std::min(spacing_mm, 100.0));
  how.threads = options.threads;
  if (auto ok = validate(how); !ok) {
    return Error{ok.error().code, "--weights: " + ok.error().message};
  }
  std::vector<Point<frames::Reference>> corners;
  double pixels = 0;
  for (const auto& group : images.groups) {
    UltrasoundImage geometry = group.geometry;
    if (!geometry.outline) geometry.outline = sector;
    const ImageArea area(geometry, clip);
    const bool backward = how.method == Method::kBackward;
    pixels += static_cast<double>(group.poses.size()) *
              static_cast<double>(backward ? geometry.pixels.pixels().size() : area.pixel_count());
    if (area.empty()) continue;
    for (const auto& pose : group.poses) {
      for (const Eigen::Vector2d& corner : area.corners()) {
        corners.push_back(pose * geometry.grid.at(corner.x(), corner.y()));
      }
    }
  }
  if (corners.empty()) {
    return Error{ErrorCode::kUsage,
                 "--clip, --fan: expected a part of the images, found that they leave no pixel"};
  }
  const auto extent = tracking::sweep_extent(corners);
  if (!(extent.motion_mm >= spacing_mm)) {
    std::ostringstream text;
    text << "the images move by at most " << extent.motion_mm << " mm, less than a voxel ("
         << spacing_mm << " mm): the volume is one image thick";
    console.report(Severity::kWarning, "reconstruct", text.str());
  }
  // Kernels that reach several voxels have room for them at the border.
  const int margin = how.method == Method::kTrilinear ? 1
                     : how.method == Method::kGaussian
                         ? static_cast<int>(std::ceil(2 * how.gaussian_voxels))
                         : 0;
  const auto grid = tracking::sweep_grid(extent, spacing_mm, margin);
  const auto fitting = [&](double times) {
    std::ostringstream text;
    text.precision(2);
    text << "; about " << 1.1 * spacing_mm * std::cbrt(times) << " mm has room";
    return text.str();
  };
  if (!grid) {
    const Eigen::Vector3d steps = (extent.high_mm - extent.low_mm) / spacing_mm;
    constexpr double kVoxelBytes = 12;
    const double bytes = kVoxelBytes * (steps.array() + 1 + 2 * margin).prod();
    return Error{grid.error().code,
                 "--spacing-mm: " + grid.error().message + fitting(bytes / kMostBytes)};
  }
  planned.grid = *grid;
  planned.bytes = reconstruction_bytes(*grid, how, pixels);
  // Marks of filled voxels, and the values before.
  if (options.fill > 0) planned.bytes += 5.0 * static_cast<double>(grid->voxel_count());
  std::ostringstream size;
  size << grid->size[0] << " x " << grid->size[1] << " x " << grid->size[2] << " voxels of "
       << spacing_mm << " mm, about " << memory_text(planned.bytes) << " of memory";
  if (planned.bytes > kMostBytes) {
    return Error{ErrorCode::kUsage, "volume: expected at most " + memory_text(kMostBytes) +
                                        " of memory, found " + size.str() +
                                        "; take a larger --spacing-mm or, beside the median and "
                                        "backward methods, another method"};
  }
  console.say("volume: " + size.str());
  return planned;
}

struct AddedImages {
  std::uint64_t used = 0;
  std::uint64_t doubtful = 0;  ///< Among them, those whose pose is not to be relied on.
  std::string first_doubt;
  std::vector<double> seconds;  ///< Time that each image took.
  std::optional<Error> failed{};
};

Result<AddedImages> add_images(session::RecordedSession& session, const PlusClip& clip,
                               bool by_confidence, int threads, Reconstruction& volume,
                               const Interrupt& interrupt, Console& console) {
  AddedImages added;
  ImageAreas areas(clip);
  session::Session::Listener listener;
  listener.settled = [&](const tracking::PairedImage& paired) {
    if (!paired.tracked) return;
    const auto area = areas.of(paired.tracked->frame);
    const auto start = std::chrono::steady_clock::now();
    Image2d<std::uint8_t> confidence;
    if (by_confidence && !area->empty()) {
      auto found = image_confidence(paired.tracked->frame, *area, threads);
      if (!found && !added.failed) added.failed = found.error();
      if (!found) return;
      confidence = *std::move(found);
    }
    volume.add(*paired.tracked, area, confidence);
    added.seconds.push_back(seconds_since(start));
    ++added.used;
    const std::string& doubt = paired.tracked->doubt;
    if (!doubt.empty() && added.doubtful++ == 0) added.first_doubt = doubt;
  };
  if (auto ok = read_all(session, listener, "images", console, interrupt); !ok) return ok.error();
  if (added.failed) return *added.failed;
  if (added.doubtful > 0) {
    console.report(Severity::kWarning, "reconstruct",
                   std::to_string(added.doubtful) +
                       " images have a doubtful pose; the first: " + added.first_doubt);
  }
  return added;
}

/// Works on another thread, so that this one shows the progress and hears Ctrl-C.
template <class Work>
auto with_progress(const char* stage, const Interrupt& interrupt, Console& console,
                   const Work& work) {
  std::stop_source stop;
  std::atomic<double> done = 0;
  const tracking::ReconstructionRun run{stop.get_token(), [&](double share) { done = share; }};
  console.begin(stage);
  auto result = std::async(std::launch::async, [&] { return work(run); });
  constexpr std::chrono::milliseconds kBetweenChecks(50);
  while (result.wait_for(kBetweenChecks) != std::future_status::ready) {
    console.progress(done);
    if (interrupt.asked()) stop.request_stop();
  }
  console.end(interrupt.asked() ? "cancelled" : "done");
  return result.get();
}

/// Images per second that the share of them reaches; null for none.
io::Json rate_of(std::vector<double> seconds, double share) {
  if (seconds.empty()) return nullptr;
  std::ranges::sort(seconds);
  const auto at = static_cast<std::size_t>(std::ceil(share * static_cast<double>(seconds.size())));
  const double taken = seconds[std::clamp<std::size_t>(at, 1, seconds.size()) - 1];
  return json_number(1 / std::max(taken, 1e-9));
}

struct WrittenFiles {
  std::filesystem::path volume, origins, scan_lines;
};

WrittenFiles volume_files_of(const ReconstructOptions& options) {
  WrittenFiles files{options.out, {}, {}};
  if (options.fill > 0)
    files.origins = std::filesystem::path(options.out).replace_extension(".origin.mha");
  if (options.method == "backward") files.scan_lines = io::scan_lines_beside(options.out);
  return files;
}

Result<void> check_volume_files(const SessionConfig& config, const WrittenFiles& files,
                                const std::optional<std::string>& json) {
  if (files.volume.extension() != ".mha") {
    return Error{ErrorCode::kUsage,
                 "--out: expected a name that ends in .mha, found '" + files.volume.string() + "'"};
  }
  const std::vector<NamedFile> outputs{{"--out", files.volume},
                                       {"origins beside --out", files.origins},
                                       {"scan lines beside --out", files.scan_lines},
                                       {"--json", json.value_or("")}};
  const std::vector<NamedFile> inputs{{"sweep", config.source.recording},
                                      {"--config", config.source.plus_config},
                                      {"--session", config.file}};
  if (auto ok = reject_overwriting(outputs, inputs); !ok) return ok;
  if (auto ok = reject_foreign({outputs[1], outputs[2]}); !ok) return ok;
  return reject_unwritable(outputs);
}

io::Json counts_json(const std::map<std::string, std::uint64_t>& counts) {
  io::Json json = io::Json::object();
  for (const auto& [cause, count] : counts) json[cause] = count;
  return json;
}

}  // namespace

Result<void> run_reconstruct(const SessionConfig& config, const ReconstructOptions& options,
                             const std::optional<std::string>& json, Console& console) {
  const auto start = std::chrono::steady_clock::now();
  const WrittenFiles files = volume_files_of(options);
  if (auto ok = check_volume_files(config, files, json); !ok) return ok;
  const auto plus = reconstruction_of_plus(config.source.plus_config);
  if (!plus) return plus.error();
  const auto clip = clip_of(options, *plus);
  if (!clip) return clip.error();
  double spacing_mm = kUsualSpacingMm;
  if (*plus && (*plus)->output_spacing_mm) spacing_mm = (*plus)->output_spacing_mm->minCoeff();
  spacing_mm = options.spacing_mm.value_or(spacing_mm);

  auto session = session::RecordedSession::open(config.source, console);
  if (!session) return session.error();
  const Interrupt interrupt;
  const auto images = survey_images(*session, config.source.skip_bad_frames, interrupt, console);
  if (!images) return images.error();
  std::optional<SectorOutline> sector;
  if (!clip->rectangle && !clip->fan) {
    sector = session::sector_of(images->spread);
  }
  const auto planned = plan_volume(options, spacing_mm, *images, sector, *clip, console);
  if (!planned) return planned.error();
  auto volume = Reconstruction::create(planned->grid, planned->options);
  if (!volume) return volume.error();

  if (auto ok = session->rewind(); !ok) return ok;
  session->set_outline(sector);
  const auto added = add_images(*session, *clip, planned->options.by_confidence, options.threads,
                                *volume, interrupt, console);
  if (!added) return added.error();
  auto values = with_progress("voxels", interrupt, console,
                              [&](const auto& run) { return volume->values(run); });
  if (!values) return values.error();
  const auto empty = static_cast<std::size_t>(std::ranges::count(*values, tracking::kUnseenVoxel));
  const std::size_t seen = values->size() - empty;
  std::vector<VoxelOrigin> origins;
  if (options.fill > 0) {
    auto filled = with_progress("holes", interrupt, console, [&](const auto& run) {
      return fill_holes(planned->grid.size, options.fill, options.threads, *values, run);
    });
    if (!filled) return filled.error();
    origins = *std::move(filled);
  }
  const auto filled = static_cast<std::size_t>(std::ranges::count(origins, VoxelOrigin::kFilled));

  if (interrupt.asked()) return reconstruction_stopped();
  console.begin("files");
  // A volume file gives positions in patient axes: those of the Reference frame.
  const VoxelGrid grid{planned->grid.size, planned->grid.spacing_mm, planned->grid.origin_mm,
                       planned->grid.directions};
  const auto stored = StoredVolume::create(grid, *std::move(values), files.volume.stem().string());
  if (!stored) return stored.error();
  if (!origins.empty()) {
    std::vector<std::int16_t> marks;
    for (const VoxelOrigin origin : origins) marks.push_back(static_cast<std::int16_t>(origin));
    const auto marked = StoredVolume::create(grid, std::move(marks), "origin");
    if (!marked) return marked.error();
    if (auto ok = io::write_ct_mha(*marked, files.origins, true, true); !ok) return ok;
  }
  if (!files.scan_lines.empty()) {
    auto ok = io::write_scan_lines(*stored, volume->scan_lines(), files.scan_lines);
    if (!ok) return ok;
  }
  if (auto ok = io::write_ct_mha(*stored, files.volume); !ok) return ok;
  console.end();

  const auto& rejected = session->navigator().ledger().rejected();
  std::uint64_t left_out = 0;
  for (const auto& [cause, count] : rejected) left_out += count;
  std::ostringstream text;
  text << files.volume.string() << ": " << added->used << " images, " << left_out << " left out; "
       << seen << " voxels seen, " << filled << " filled, " << empty - filled << " empty";
  console.say(text.str());
  if (!json) return {};
  io::Json report;
  report["verb"] = "reconstruct";
  report["version"] = SONDE_VERSION;
  report["volume"] = files.volume.string();
  report["method"] = options.method;
  report["compound"] = options.compound;
  report["weights"] = options.weights;
  report["reference"] = session->reference_statement();
  report["sector"] = sector ? "learned" : clip->rectangle || clip->fan ? "given" : "none";
  report["frames"] = {
      {"used", added->used}, {"doubtful", added->doubtful}, {"rejected", counts_json(rejected)}};
  report["size"] = planned->grid.size;
  report["voxels"] = {{"seen", seen}, {"filled", filled}, {"empty", empty - filled}};
  report["spacing_mm"] = spacing_mm;
  report["bytes"] = planned->bytes;
  // The backward method computes voxels, not images.
  const auto seconds = options.method == "backward" ? std::vector<double>() : added->seconds;
  report["fps_p50"] = rate_of(seconds, 0.5);
  report["fps_p95"] = rate_of(seconds, 0.95);
  report["seconds"] = seconds_since(start);
  report["sha256"] = io::digest_of(*stored);
  add_messages(report, console.entries());
  return write_json(report, *json);
}

}  // namespace nav::app
