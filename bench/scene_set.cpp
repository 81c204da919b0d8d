// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/scene_set.hpp"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <unistd.h>

#include "io/ct.hpp"
#include "render/parallel.hpp"
#include "sim/ct_scanner.hpp"

namespace nav::bench {
namespace {

namespace fs = std::filesystem;

/// A volume of the set under the data folder.
struct Source {
  const char* name;
  const char* path;
  const char* archive;  ///< Archive that holds path's folder; empty: path exists unpacked.
  std::vector<const char*> appearances;
};

const std::vector<Source>& sources() {
  static const std::vector<Source> all{
      {"head", "ct-headsq/dicom", "", {"raw-bone", "raw-soft-tissue"}},
      {"abdomen", "ct-abdomen-totalseg/example_ct.nii.gz", "", {"ct-bone", "ct-soft-tissue"}},
      {"aorta", "cta-aorta-totalseg/ct_cropped.nii.gz", "", {"cta-vessels", "vessels-only"}},
      {"lung", "ct-lung-elastix/3DCT_lung.mha", "", {"ct-bone", "ct-soft-tissue"}},
      {"pelvis",
       "ucl-pelvis/dicom_2mm_236",
       "ucl-pelvis/dicom_2mm_236.tar.zst",
       {"ct-bone", "ct-soft-tissue"}}};
  return all;
}

/// A preset for values that are HU + 1024, as in the head's file, which does not state this.
Result<render::TransferFunction> raw_appearance(const std::string& name,
                                                const std::string& preset) {
  auto transfer = render::preset_transfer_function(preset);
  if (!transfer) return transfer;
  std::vector<render::TransferComponent> components = transfer->components();
  for (auto& component : components) {
    for (auto& node : component.nodes) node.hu += 1024;
  }
  return render::TransferFunction::blend(name, std::move(components));
}

Result<render::TransferFunction> appearance(const std::string& name) {
  if (name == "vessels-only") return vessels_only();
  if (name == "raw-bone") return raw_appearance(name, "ct-bone");
  if (name == "raw-soft-tissue") return raw_appearance(name, "ct-soft-tissue");
  return render::preset_transfer_function(name);
}

Result<BenchVolume> with_looks(const std::string& name, std::shared_ptr<const Volume> ct,
                               const std::vector<const char*>& appearances) {
  BenchVolume volume{name, std::move(ct), {}};
  for (const char* one : appearances) {
    auto transfer = appearance(one);
    if (!transfer) return transfer.error();
    volume.appearances.push_back(std::move(*transfer));
  }
  return volume;
}

/// Folder for an unpacked archive, removed together with the object.
class UnpackFolder {
 public:
  UnpackFolder()
      : path_(fs::temp_directory_path() / ("sonde_bench_" + std::to_string(::getpid()))) {}
  ~UnpackFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  UnpackFolder(const UnpackFolder&) = delete;
  UnpackFolder& operator=(const UnpackFolder&) = delete;

  /// Returns false if tar, zstd or the archive fails.
  bool unpack(const fs::path& archive) {
    std::error_code error;
    fs::create_directories(path_, error);
    const std::string command =
        "tar -I zstd -xf '" + archive.string() + "' -C '" + path_.string() + "' 2>/dev/null";
    return !error && std::system(command.c_str()) == 0;
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Absent, with a reported reason, if the data is missing.
std::shared_ptr<const Volume> read(const Source& source, const fs::path& data,
                                   Diagnostics& diagnostics) {
  const auto skipped = [&](const std::string& why) {
    diagnostics.report(Severity::kWarning, "bench",
                       std::string(source.name) + " skipped: " + why + " (set SONDE_DATA_DIR)");
  };
  fs::path path = data / source.path;
  UnpackFolder unpacked;
  if (!fs::exists(path) && *source.archive != '\0') {
    const fs::path archive = data / source.archive;
    if (!fs::exists(archive)) {
      skipped("expected " + path.string() + " or " + archive.string() + ", found neither");
      return {};
    }
    if (!unpacked.unpack(archive)) {
      skipped("tar -I zstd could not unpack " + archive.string());
      return {};
    }
    path = unpacked.path();
    const fs::path inside = unpacked.path() / fs::path(source.path).filename();
    if (fs::exists(inside)) path = inside;
  }
  if (!fs::exists(path)) {
    skipped("expected " + path.string() + ", found no file");
    return {};
  }
  auto ct = io::read_ct(path, diagnostics);
  if (!ct) {
    skipped(ct.error().message);
    return {};
  }
  return std::make_shared<const Volume>(std::move(*ct));
}

/// Position of the eye and kind of projection.
struct View {
  const char* name;
  bool orthographic;
  Eigen::Vector3d towards_eye;  ///< LPS.
};

render::Camera camera_of(const View& view, const VoxelGrid& grid) {
  constexpr double kFovRad = 0.5;
  // Fraction of the circumscribed sphere that fills the image height.
  constexpr double kPart = 0.8;
  const double radius = 0.5 * grid.extent_mm().norm() * kPart;
  render::Camera camera;
  camera.look_at_ct = grid.centre();
  camera.eye_ct = {grid.centre().mm +
                   radius / std::sin(kFovRad / 2) * view.towards_eye.normalized()};
  camera.up_ct = {Eigen::Vector3d::UnitZ()};
  camera.vertical_fov_rad = kFovRad;
  camera.orthographic = view.orthographic;
  camera.orthographic_height_mm = 2 * radius;
  return camera;
}

const std::vector<View>& views() {
  static const std::vector<View> both{{"perspective", false, {0.55, -0.75, 0.35}},
                                      {"orthographic", true, {-0.2, -0.8, 0.55}}};
  return both;
}

std::string name_of(const std::string& volume, const std::string& appearance, const View& view,
                    bool shaded) {
  return volume + "/" + appearance + "/" + view.name + "/" + (shaded ? "shaded" : "unshaded");
}

/// Sum of three uniform numbers of variance 1/3 each, from a voxel's number: mean 0, variance 1.
double noise_of(std::size_t voxel) {
  double sum = 0;
  for (std::uint64_t i = 0; i < 3; ++i) {
    std::uint64_t h = (voxel * 3 + i) * 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 31)) * 0xbf58476d1ce4e5b9ULL;
    sum += static_cast<double>((h ^ (h >> 29)) >> 11) / 9007199254740992.0;
  }
  return 2 * (sum - 1.5);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// True if some scene of a volume has a name that contains filter.
bool wanted(const std::string& volume, const std::vector<const char*>& appearances,
            const std::string& filter) {
  for (const char* one : appearances) {
    for (const View& view : views()) {
      for (const bool shaded : {false, true}) {
        if (contains(name_of(volume, one, view, shaded), filter)) return true;
      }
    }
  }
  return false;
}

}  // namespace

fs::path bench_data_dir() {
  if (const char* dir = std::getenv("SONDE_DATA_DIR")) return dir;
  return fs::path("..") / "shared" / "data";
}

Result<std::shared_ptr<const Volume>> simulated_ct() {
  auto ct = sim::scan_ct(sim::AbdomenPhantom(sim::PhantomOptions{}));
  if (!ct) return ct.error();
  return std::make_shared<const Volume>(std::move(*ct));
}

render::Scene nudged(render::Scene scene, int frame) {
  scene.camera.eye_ct.mm += 1e-3 * frame * Eigen::Vector3d(0.6, 0.8, 0);
  return scene;
}

Result<std::shared_ptr<const Volume>> cubic_patient(int n, double scanned_mm) {
  constexpr double kSideMm = 300;
  // Scans shared by volumes of several sizes of the same patient.
  static std::map<double, Result<Volume>> bases;
  if (!bases.contains(scanned_mm)) {
    sim::CtOptions options;
    options.spacing_mm.setConstant(scanned_mm);
    options.noise_hu = 0;
    options.region = {Eigen::Vector3d::Constant(-0.5 * kSideMm),
                      Eigen::Vector3d::Constant(0.5 * kSideMm)};
    bases.emplace(scanned_mm, sim::scan_ct(sim::AbdomenPhantom(sim::PhantomOptions{}), options));
  }
  const Result<Volume>& base = bases.at(scanned_mm);
  if (!base) return base.error();
  VoxelGrid grid;
  grid.size = {n, n, n};
  grid.spacing_mm.setConstant(0.999 * kSideMm / n);
  grid.origin_mm.setConstant(-0.5 * (n - 1) * grid.spacing_mm.x());
  std::vector<std::int16_t> hu(grid.voxel_count());
  render::for_each_index(n, 0, [&](int k) {
    std::size_t at =
        static_cast<std::size_t>(k) * static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i, ++at) {
        const double clean = base->sample(grid.at({1.0 * i, 1.0 * j, 1.0 * k})).value_or(kAirHu);
        hu[at] = static_cast<std::int16_t>(std::lround(clean + 12 * noise_of(at)));
      }
    }
  });
  auto volume = Volume::create(grid, std::move(hu), "patient of " + std::to_string(n));
  if (!volume) return volume.error();
  return std::make_shared<const Volume>(std::move(*volume));
}

render::TransferFunction vessels_only() {
  auto made = render::TransferFunction::create("vessels-only", {{-1024, {0.8, 0.08, 0.06}, 0, 1},
                                                                {180, {0.8, 0.08, 0.06}, 0, 1},
                                                                {220, {0.8, 0.08, 0.06}, 0.15, 1},
                                                                {440, {0.9, 0.16, 0.1}, 0.3, 1},
                                                                {480, {0.9, 0.16, 0.1}, 0, 1}});
  NAV_CHECK(made.has_value());
  return *made;
}

Result<BenchVolume> bench_volume(const std::string& name, std::shared_ptr<const Volume> ct) {
  return with_looks(name, std::move(ct), {"ct-bone", "cta-vessels"});
}

Result<std::vector<BenchVolume>> bench_volumes(const std::string& filter, const fs::path& data,
                                               Diagnostics& diagnostics) {
  std::vector<BenchVolume> volumes;
  const std::vector<const char*> simulated_appearances{"cta-vessels", "ct-soft-tissue"};
  if (wanted("simulated-patient", simulated_appearances, filter)) {
    auto ct = simulated_ct();
    if (!ct) return ct.error();
    auto volume = with_looks("simulated-patient", *ct, simulated_appearances);
    if (!volume) return volume.error();
    volumes.push_back(std::move(*volume));
  }
  for (const Source& source : sources()) {
    if (!wanted(source.name, source.appearances, filter)) continue;
    auto ct = read(source, data, diagnostics);
    if (!ct) continue;
    auto volume = with_looks(source.name, std::move(ct), source.appearances);
    if (!volume) return volume.error();
    volumes.push_back(std::move(*volume));
  }
  return volumes;
}

std::vector<NamedScene> bench_scenes(const std::vector<BenchVolume>& volumes,
                                     const std::string& filter, int width, int height) {
  std::vector<NamedScene> scenes;
  for (const BenchVolume& volume : volumes) {
    for (const auto& transfer : volume.appearances) {
      for (const View& view : views()) {
        for (const bool shaded : {false, true}) {
          const std::string name = name_of(volume.name, transfer.name(), view, shaded);
          if (!contains(name, filter)) continue;
          render::Scene scene{.ct = volume.ct,
                              .transfer = transfer,
                              .shading = {},
                              .plane = {},
                              .needle = {},
                              .spheres = {},
                              .camera = camera_of(view, volume.ct->grid()),
                              .quality = {},
                              .lines = {},
                              .cutaway = {}};
          scene.shading.enabled = shaded;
          scene.width = width;
          scene.height = height;
          scenes.push_back({name, std::move(scene)});
        }
      }
    }
  }
  return scenes;
}

render::Scene bare(const render::Scene& scene) {
  render::Scene out = scene;
  out.plane.reset();
  out.needle.reset();
  out.spheres.clear();
  out.lines.clear();
  out.cutaway.reset();
  out.shading.enabled = false;
  return out;
}

}  // namespace nav::bench
