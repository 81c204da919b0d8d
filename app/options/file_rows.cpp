// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Options of files, of the CT, of the recording and of the placement.
#include <filesystem>
#include <locale>
#include <sstream>

#include "app/options/option_rows.hpp"
#include "app/options/session_devices.hpp"
#include "app/options/session_section.hpp"
#include "app/options/session_structures.hpp"
#include "io/transform_file.hpp"
#include "nav/positions.hpp"

namespace nav::app {
namespace {

using Matrix = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

const std::vector<std::string_view> kSessions{"replay", "live", "slices", "predicates"};
const std::vector<std::string_view> kPlaying{"replay", "register", "slices", "reconstruct"};

/// A placement on the command line replaces either kind of a session file. A transform file is read
/// when the verb begins.
Result<void> take_matrix(Settings& s, const std::vector<std::string>& values) {
  if (io::is_transform_file(values.front())) {
    s.config.placement.transform = values.front();
    s.config.placement.ct_from_reference.reset();
    s.config.placement.registration.clear();
    return {};
  }
  std::string spaced = values.front();
  for (char& c : spaced) c = c == ',' ? ' ' : c;
  std::istringstream stream(spaced);
  stream.imbue(std::locale::classic());
  std::vector<double> numbers;
  for (double number = 0; stream >> number;) numbers.push_back(number);
  if (numbers.size() != 16 || !stream.eof()) {
    return unreadable("16 numbers or a transform file (.tfm)", values.front());
  }
  s.config.placement.ct_from_reference = Eigen::Map<const Matrix>(numbers.data());
  s.config.placement.registration.clear();
  return {};
}

void read_matrix(Section& section, const char* key, Settings& s) {
  std::vector<double> numbers;
  section.numbers(key, 16, numbers);
  if (numbers.empty()) return;
  s.config.placement.ct_from_reference = Eigen::Map<const Matrix>(numbers.data());
}

void write_matrix(KeyWriter& writer, const char* key, const Settings& s) {
  if (!s.config.placement.ct_from_reference) return;
  const Matrix rows = *s.config.placement.ct_from_reference;
  toml::array numbers;
  for (const double number : rows.reshaped<Eigen::RowMajor>()) numbers.push_back(number);
  writer.table.insert(key, std::move(numbers));
}

void read_registration(Section& section, const char* key, Settings& s) {
  section.path(key, s.config.placement.registration);
  if (s.config.placement.ct_from_reference && !s.config.placement.registration.empty()) {
    section.reject(key, "it or placement.ct_from_reference_mm", "both");
  }
}

void write_registration(KeyWriter& writer, const char* key, const Settings& s) {
  writer.table.insert(key, writer.path(s.config.placement.registration));
}

void read_kind(Section& section, const char* key, Settings& s) {
  std::string kind = "recording";
  section.text(key, kind);
  if (kind == "simulated") {
    s.config.source.kind = SessionConfig::SourceKind::kSimulated;
  } else if (kind == "live") {
    s.config.source.kind = SessionConfig::SourceKind::kLive;
  } else if (kind != "recording") {
    section.reject(key, "recording, simulated or live", kind);
  }
}

void write_kind(KeyWriter& writer, const char* key, const Settings& s) {
  using Kind = SessionConfig::SourceKind;
  const Kind kind = s.config.source.kind;
  writer.table.insert(key, kind == Kind::kSimulated ? "simulated"
                           : kind == Kind::kLive    ? "live"
                                                    : "recording");
}

/// The name that a live session gives to the configuration of PLUS.
void read_calibration(Section& section, const char* key, Settings& s) {
  const bool both = !s.config.source.plus_config.empty();
  std::filesystem::path calibration;
  section.path(key, calibration);
  if (calibration.empty()) return;
  if (both) section.reject(key, "it or source.plus_config", "both");
  s.config.source.plus_config = calibration;
}

void write_calibration(KeyWriter&, const char*, const Settings&) {}

Requirement ct_to_register() { return {.any_of = {{"--ct"}}, .verb = "register"}; }

}  // namespace

std::string found_number(double number) {
  std::ostringstream text;
  text << number;
  return text.str();
}

std::string found_point(const Eigen::Vector3d& mm) {
  std::ostringstream text;
  text << mm.transpose();
  return text.str();
}

Error unreadable(const std::string& expected, const std::string& text) {
  return {ErrorCode::kUsage, "expected " + expected + ", found '" + text + "'"};
}

Requirement recording_session() {
  return {.met =
              [](const Settings& s) {
                return s.config.source.kind == SessionConfig::SourceKind::kRecording;
              },
          .text = "a session of a recording",
          .found = [](const Settings& s) -> std::string {
            const bool live = s.config.source.kind == SessionConfig::SourceKind::kLive;
            return live ? "one of live devices (sonde live)" : "the simulated procedure";
          },
          .verb = "replay"};
}

Requirement sweep_to_register() {
  return {.met = [](const Settings& s) { return !s.config.source.recording.empty(); },
          .text = "a sweep",
          .verb = "register"};
}

Requirement recording_to_slice() { return {.any_of = {{"--recording"}}, .verb = "slices"}; }

Requirement dicom_folder() {
  return {.met =
              [](const Settings& s) {
                std::error_code ignored;
                return !std::filesystem::is_regular_file(s.config.ct.path, ignored);
              },
          .text = "a DICOM folder",
          .found = [](const Settings& s) { return s.config.ct.path.string(); }};
}

void add_file_rows(std::vector<Option>& rows) {
  const std::vector<Option> files{
      {.name = "sweep",
       .type = "SWEEP",
       .text =
           "recording to replay: a PLUS sequence (.igs.mha, .mhd, .nrrd) or one of devices (.mcap)",
       .group = group::kGroupFiles,
       .verbs = {"replay"},
       .slot = NAV_SLOT(config.source.recording),
       .absent = "from the session file",
       .usual = true,
       .key = "source.recording",
       .needs = {recording_session()}},
      {.name = "recording",
       .type = "MCAP",
       .text = "recording of devices (sonde record)",
       .group = group::kGroupFiles,
       .verbs = {"export"},
       .slot = NAV_SLOT(config.source.recording),
       .usual = true,
       .required = true},
      {.name = "sweep",
       .type = "SWEEP",
       .text = "recording of a sweep, a PLUS sequence or one of devices",
       .group = group::kGroupFiles,
       .verbs = {"reconstruct"},
       .slot = NAV_SLOT(config.source.recording),
       .usual = true,
       .required = true},
      {.name = "sweep",
       .type = "SWEEP",
       .text = "recording that the CT is registered to, a PLUS sequence or one of devices",
       .group = group::kGroupFiles,
       .verbs = {"register"},
       .slot = NAV_SLOT(config.source.recording),
       .absent = "landmarks or points alone",
       .usual = true},
      {.name = "ct",
       .type = "CT",
       .text = "CT: DICOM folder, NIfTI, MetaImage or NRRD",
       .group = group::kGroupFiles,
       .verbs = {"slices"},
       .slot = NAV_SLOT(config.ct.path),
       .absent = "from the session file",
       .usual = true},
      {.name = "volume",
       .type = "VOLUME",
       .text = "3D ultrasound: DICOM folder, NIfTI, MetaImage or NRRD",
       .group = group::kGroupFiles,
       .verbs = {"predicates"},
       .slot = NAV_SLOT(config.predicates.volume),
       .absent = "a phantom",
       .usual = true},
      {.name = "volume",
       .type = "VOLUME",
       .text = "3D ultrasound: DICOM folder, NIfTI, MetaImage or NRRD",
       .group = group::kGroupFiles,
       .verbs = {"derive"},
       .slot = NAV_SLOT(derive.volume),
       .usual = true,
       .required = true},
      {.name = "file",
       .type = "FILE",
       .text =
           "sequence, recording, volume (file or DICOM folder), registration, transform, points, "
           "surface or PLUS configuration",
       .group = group::kGroupFiles,
       .verbs = {"info"},
       .slot = NAV_SLOT(file),
       .usual = true,
       .required = true},
      {.name = "--session",
       .type = "FILE",
       .text = "session file (TOML); options win over it",
       .group = group::kGroupFiles,
       .verbs = kSessions,
       .slot = NAV_SLOT(session),
       .absent = "none",
       .usual = true},
      {.name = "--session",
       .type = "FILE",
       .text = "session file (TOML) whose devices are started",
       .group = group::kGroupFiles,
       .verbs = {"devices", "serve", "emulate", "record"},
       .slot = NAV_SLOT(session),
       .absent = "none",
       .usual = true},
      {.name = "--out",
       .type = "DIR",
       .text = "folder to write to",
       .group = group::kGroupFiles,
       .verbs = {"demo"},
       .slot = NAV_SLOT(config.output.folder),
       .usual = true,
       .required = true},
      {.name = "--out",
       .type = "DIR",
       .text = "folder to write to",
       .group = group::kGroupFiles,
       .verbs = {"replay", "live", "slices"},
       .slot = NAV_SLOT(config.output.folder),
       .absent = "from the session file",
       .usual = true,
       .key = "output.folder"},
      {.name = "--out",
       .type = "DIR",
       .text = "folder for the report, and for a sweep an image before and after",
       .group = group::kGroupFiles,
       .verbs = {"register"},
       .slot = NAV_SLOT(config.output.folder),
       .absent = "none",
       .usual = true},
      {.name = "--out",
       .type = "PNG",
       .text = "image to write",
       .group = group::kGroupFiles,
       .verbs = {"predicates"},
       .slot = NAV_SLOT(config.predicates.image),
       .absent = "from the session file",
       .usual = true,
       .key = "predicates.picture",
       .written_when_set = true},
      {.name = "--out",
       .type = "DIR",
       .text = "folder to write to",
       .group = group::kGroupFiles,
       .verbs = {"derive"},
       .slot = NAV_SLOT(derive.out),
       .usual = true,
       .required = true},
      {.name = "--out",
       .type = "MCAP",
       .text = "recording to write, which must not exist",
       .group = group::kGroupFiles,
       .verbs = {"record"},
       .slot = NAV_SLOT(config.output.record),
       .usual = true,
       .required = true},
      {.name = "--out",
       .type = "SWEEP",
       .text = "PLUS sequence to write, .mha or .nrrd",
       .group = group::kGroupFiles,
       .verbs = {"export"},
       .slot = NAV_SLOT(exported.out),
       .usual = true,
       .required = true},
      {.name = "--out",
       .type = "MHA",
       .text = "volume to write, .mha; what belongs to it is written beside it",
       .group = group::kGroupFiles,
       .verbs = {"reconstruct"},
       .slot = NAV_SLOT(reconstruct.out),
       .usual = true,
       .required = true},
      {.name = "--compress",
       .text = "compress the images",
       .group = group::kGroupFiles,
       .verbs = {"export"},
       .slot = NAV_SLOT(exported.compress)},
      {.name = "--out",
       .type = "SWEEP",
       .text = "recording to write, .mha or .nrrd",
       .group = group::kGroupFiles,
       .verbs = {"simulate"},
       .slot = NAV_SLOT(simulate.out),
       .usual = true,
       .required = true},
      {.name = "--json",
       .type = "FILE",
       .text = "also write the report as JSON here; -: standard output",
       .group = group::kGroupFiles,
       .verbs = {"demo", "replay", "live", "window", "record", "serve", "emulate", "info",
                 "devices", "reconstruct"},
       .slot = NAV_SLOT(json),
       .absent = "none",
       .usual = true},
      {.name = "--json",
       .type = "FILE",
       .text = "write the result as JSON here; -: standard output",
       .group = group::kGroupFiles,
       .verbs = {"register"},
       .slot = NAV_SLOT(json),
       .absent = "standard output",
       .usual = true},
      {.name = "--print-session",
       .text = "print the resolved session file and stop",
       .group = group::kGroupFiles,
       .verbs = kSessions,
       .slot = NAV_SLOT(print_session)}};
  rows.insert(rows.end(), files.begin(), files.end());
}

void add_recording_rows(std::vector<Option>& rows) {
  const std::vector<Option> ct{
      {.name = "--ct",
       .type = "CT",
       .text = "CT: DICOM folder, NIfTI, MetaImage or NRRD",
       .group = group::kGroupRecording,
       .verbs = {"replay", "live", "register"},
       .slot = NAV_SLOT(config.ct.path),
       .absent = "from the session file",
       .usual = true,
       .key = "ct.path",
       .needs = {recording_session()}},
      {.name = "--series",
       .type = "UID",
       .text = "SeriesInstanceUID of the CT in a DICOM folder with several series",
       .group = group::kGroupRecording,
       .verbs = {"replay", "live", "register", "slices"},
       .slot = NAV_SLOT(config.ct.series_uid),
       .absent = "the largest series",
       .key = "ct.series_uid",
       .needs = {recording_session(), ct_to_register(), dicom_folder()}},
      {.name = "--accept-unknown-orientation",
       .text = "read a CT that does not state its orientation as LPS",
       .group = group::kGroupRecording,
       .verbs = {"replay", "live", "register", "slices", "info"},
       .slot = NAV_SLOT(config.ct.accept_unknown_orientation),
       .key = "ct.accept_unknown_orientation",
       .needs = {recording_session(), ct_to_register()}},
      {.type = "NAME",
       .text = "kind of the source: recording, simulated or live",
       .group = group::kGroupRecording,
       .absent = "recording",
       .key = "source.kind",
       .read = read_kind,
       .write = write_kind},
      {.name = "--config",
       .type = "PLUS.xml",
       .text = "PLUS configuration with the calibration of the probe",
       .group = group::kGroupRecording,
       .verbs = {"replay", "register", "slices", "export", "reconstruct"},
       .slot = NAV_SLOT(config.source.plus_config),
       .absent = "the calibration of the recording",
       .usual = true,
       .key = "source.plus_config",
       .needs = {recording_session(), sweep_to_register(), recording_to_slice()}},
      {.type = "PLUS.xml",
       .text = "another name of source.plus_config, for live sessions",
       .group = group::kGroupRecording,
       .absent = "none",
       .key = "source.calibration",
       .read = read_calibration,
       .write = write_calibration},
      {.name = "--image-frame",
       .type = "NAME",
       .text = "coordinate frame of the images in the recording",
       .group = group::kGroupRecording,
       .verbs = kPlaying,
       .slot = NAV_SLOT(config.source.image_frame),
       .key = "source.image_frame",
       .needs = {recording_session(), sweep_to_register(), recording_to_slice()}},
      {.name = "--probe-frame",
       .type = "NAME",
       .text = "coordinate frame of the probe in the recording",
       .group = group::kGroupRecording,
       .verbs = kPlaying,
       .slot = NAV_SLOT(config.source.probe_frame),
       .key = "source.probe_frame",
       .needs = {recording_session(), sweep_to_register(), recording_to_slice()}},
      {.name = "--tracker-frame",
       .type = "NAME",
       .text = "coordinate frame of the tracker in the recording",
       .group = group::kGroupRecording,
       .verbs = kPlaying,
       .slot = NAV_SLOT(config.source.tracker_frame),
       .key = "source.tracker_frame",
       .needs = {recording_session(), sweep_to_register(), recording_to_slice()}},
      {.name = "--reference-frame",
       .type = "NAME",
       .text = "patient-fixed coordinate frame; the name of the tracker frame declares the tracker "
               "to be it",
       .group = group::kGroupRecording,
       .verbs = kPlaying,
       .slot = NAV_SLOT(config.source.reference_frame),
       .absent = "Reference if the recording has it, otherwise the tracker",
       .key = "source.reference_frame",
       .needs = {recording_session(), recording_to_slice()}},
      {.name = "--needle-frame",
       .type = "NAME",
       .text = "coordinate frame of the needle tip, +z from the hub to the tip, such as NeedleTip; "
               "without it no needle is drawn",
       .group = group::kGroupRecording,
       .verbs = {"replay", "register", "slices"},
       .slot = NAV_SLOT(config.source.needle_frame),
       .absent = "none",
       .usual = true,
       .may_be_empty = true,
       .key = "source.needle_frame",
       .needs = {recording_session(), sweep_to_register(), recording_to_slice()}},
      {.name = "--temporal-offset-ms",
       .type = "MS",
       .unit = "ms",
       .text = "time stamps of images minus those of poses",
       .group = group::kGroupRecording,
       .verbs = {"replay", "register", "slices", "export", "reconstruct"},
       .slot = NAV_SLOT(config.source.temporal_offset_ms),
       .range = within(-10000, 10000),
       .key = "source.temporal_offset_ms",
       .needs = {recording_session(), sweep_to_register(), recording_to_slice()}},
      {.name = "--skip-bad-frames",
       .text = "skip images whose data are impossible; they are counted by cause",
       .group = group::kGroupRecording,
       .verbs = kPlaying,
       .slot = NAV_SLOT(config.source.skip_bad_frames),
       .key = "source.skip_bad_frames",
       .needs = {recording_session(), sweep_to_register(), recording_to_slice()}},
      {.type = "N",
       .text = "seed of the simulated procedure",
       .group = group::kGroupRecording,
       .slot = NAV_SLOT(config.source.seed),
       .key = "source.seed"},
      {.type = "LIST",
       .text = "devices of a live session, a list of tables (docs/live.md)",
       .group = group::kGroupRecording,
       .absent = "none",
       .key = "devices",
       .always = {{.met =
                       [](const Settings& s) {
                         return s.config.source.devices.empty() ||
                                s.config.source.kind == SessionConfig::SourceKind::kLive;
                       },
                   .text = "source.kind = \"live\" beside them",
                   .found = [](const Settings& s) -> std::string {
                     const bool simulated =
                         s.config.source.kind == SessionConfig::SourceKind::kSimulated;
                     return simulated ? "simulated" : "recording";
                   }}},
       .read = read_devices,
       .write = write_devices},
      {.name = "--ct-from-reference",
       .type = "\"16 NUMBERS\"|TFM",
       .unit = "mm",
       .text = "declared placement of the CT, row-major, on the command line also the ITK "
               "transform file of ReferenceToRas (3D Slicer); the start pose of register",
       .group = group::kGroupRecording,
       .verbs = {"replay", "live", "register", "slices"},
       .absent = "none",
       .key = "placement.ct_from_reference_mm",
       .needs = {recording_session(), recording_to_slice()},
       .idle_with = {{"--landmarks"}},
       .excludes = {"--registration"},
       .always = {{.met =
                       [](const Settings& s) {
                         const auto& matrix = s.config.placement.ct_from_reference;
                         return !matrix ||
                                is_place(Eigen::Vector3d(matrix->topRightCorner<3, 1>()));
                       },
                   .text = "a translation within 1e7 mm",
                   .found =
                       [](const Settings& s) {
                         return found_point(
                             s.config.placement.ct_from_reference->topRightCorner<3, 1>());
                       }}},
       .take = take_matrix,
       .read = read_matrix,
       .write = write_matrix},
      {.name = "--registration",
       .type = "FILE",
       .text = "result of sonde register, which places the CT",
       .group = group::kGroupRecording,
       .verbs = {"replay", "live", "slices"},
       .slot = NAV_SLOT(config.placement.registration),
       .absent = "none: the sweep is centred on the CT",
       .usual = true,
       .key = "placement.registration",
       .needs = {recording_session(), recording_to_slice()},
       .before = [](Settings& s) { s.config.placement.ct_from_reference.reset(); },
       .read = read_registration,
       .write = write_registration}};
  rows.insert(rows.end(), ct.begin(), ct.end());
}

void add_plan_rows(std::vector<Option>& rows) {
  const auto read_point = [](Section& section, const char* key, Eigen::Vector3d& point) {
    std::vector<double> mm(3);
    section.required_numbers(key, 3, mm);
    point = Eigen::Map<const Eigen::Vector3d>(mm.data());
  };
  static constexpr auto kReadPoint = read_point;
  static constexpr auto kPlanOf = [](Settings& s) -> NeedlePlan& {
    if (!s.config.plan) s.config.plan = NeedlePlan{{{}}, {{}}, 0, 0};
    return *s.config.plan;
  };
  static constexpr auto kWritePoint = [](KeyWriter& writer, const char* key,
                                         const Eigen::Vector3d& p) {
    writer.table.insert(key, toml::array{p.x(), p.y(), p.z()});
  };
  const std::vector<Option> plan{
      {.type = "MM",
       .unit = "mm",
       .text = "entry of the planned path on the skin, LPS",
       .group = group::kGroupPlan,
       .range = within(-1e6, 1e6),
       .absent = "required in a plan",
       .key = "plan.entry_mm",
       .always = {{.met =
                       [](const Settings& s) {
                         return !s.config.plan || s.config.plan->entry_ct.mm.norm() <= 1e6;
                       },
                   .text = "a position within 10^6 mm",
                   .found =
                       [](const Settings& s) { return found_point(s.config.plan->entry_ct.mm); }}},
       .read =
           [](Section& section, const char* key, Settings& s) {
             if (section.is_there()) kReadPoint(section, key, kPlanOf(s).entry_ct.mm);
           },
       .write =
           [](KeyWriter& writer, const char* key, const Settings& s) {
             if (s.config.plan) kWritePoint(writer, key, s.config.plan->entry_ct.mm);
           }},
      {.type = "MM",
       .unit = "mm",
       .text = "centre of the lesion, LPS",
       .group = group::kGroupPlan,
       .range = within(-1e6, 1e6),
       .absent = "required in a plan",
       .key = "plan.target_mm",
       .always = {{.met =
                       [](const Settings& s) {
                         return !s.config.plan || s.config.plan->target_ct.mm.norm() <= 1e6;
                       },
                   .text = "a position within 10^6 mm",
                   .found =
                       [](const Settings& s) { return found_point(s.config.plan->target_ct.mm); }}},
       .read =
           [](Section& section, const char* key, Settings& s) {
             if (section.is_there()) kReadPoint(section, key, kPlanOf(s).target_ct.mm);
           },
       .write =
           [](KeyWriter& writer, const char* key, const Settings& s) {
             if (s.config.plan) kWritePoint(writer, key, s.config.plan->target_ct.mm);
           }},
      {.type = "MM",
       .unit = "mm",
       .text = "radius of the lesion, a sphere",
       .group = group::kGroupPlan,
       .range = within(0.1, 500),
       .absent = "required in a plan",
       .key = "plan.target_radius_mm",
       .always = {{.met =
                       [](const Settings& s) {
                         return !s.config.plan || (s.config.plan->target_radius_mm >= 0.1 &&
                                                   s.config.plan->target_radius_mm <= 500);
                       },
                   .text = "0.1 to 500",
                   .found =
                       [](const Settings& s) {
                         return found_number(s.config.plan->target_radius_mm);
                       }}},
       .read =
           [](Section& section, const char* key, Settings& s) {
             if (section.is_there()) section.required_number(key, kPlanOf(s).target_radius_mm);
           },
       .write =
           [](KeyWriter& writer, const char* key, const Settings& s) {
             if (s.config.plan) writer.table.insert(key, s.config.plan->target_radius_mm);
           }},
      {.type = "MM",
       .unit = "mm",
       .text = "safety margin beyond the radius, drawn as a faint sphere",
       .group = group::kGroupPlan,
       .range = within(0, 500),
       .absent = "0",
       .key = "plan.margin_mm",
       .always = {{.met =
                       [](const Settings& s) {
                         return !s.config.plan ||
                                (s.config.plan->margin_mm >= 0 && s.config.plan->margin_mm <= 500);
                       },
                   .text = "0 to 500",
                   .found =
                       [](const Settings& s) { return found_number(s.config.plan->margin_mm); }}},
       .read =
           [](Section& section, const char* key, Settings& s) {
             if (section.is_there()) section.number(key, kPlanOf(s).margin_mm);
           },
       .write =
           [](KeyWriter& writer, const char* key, const Settings& s) {
             if (s.config.plan) writer.table.insert(key, s.config.plan->margin_mm);
           }},
      {.type = "LIST",
       .text = "structures that the path has to stay away from, a list of tables: name, "
               "clearance_mm, and centre_mm with radius_mm, or low_hu with high_hu",
       .group = group::kGroupPlan,
       .absent = "none",
       .key = "critical_structures",
       .read = read_structures,
       .write = write_structures}};
  rows.insert(rows.end(), plan.begin(), plan.end());
}

}  // namespace nav::app
