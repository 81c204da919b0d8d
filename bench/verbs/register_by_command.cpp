// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/register_by_command.hpp"

#include <cstring>
#include <fstream>
#include <iomanip>
#include <sstream>

#include "app/report.hpp"
#include "app/verbs/simulate/simulated_recording.hpp"
#include "bench/registration/child_program.hpp"
#include "io/json.hpp"
#include "io/sequence_writer.hpp"
#include "session/registration_file.hpp"

namespace nav::bench {
namespace {

Result<void> write_recording(const Sweep& sweep, const std::filesystem::path& file) {
  io::SequenceHeader header;
  header.width = sweep.frames().front().frame.pixels.width();
  header.height = sweep.frames().front().frame.pixels.height();
  auto writer = io::SequenceWriter::create(file, header);
  if (!writer) return writer.error();
  for (const TrackedImage& tracked : sweep.frames()) {
    const auto pixels = tracked.frame.pixels.pixels();
    io::SequenceImage frame;
    frame.timestamp_s = to_seconds(tracked.frame.acquired);
    frame.unfiltered_timestamp_s = frame.timestamp_s;
    frame.image_valid = true;
    frame.pixels.resize(pixels.size());
    std::memcpy(frame.pixels.data(), pixels.data(), pixels.size());
    io::set_transform(
        frame, {"ProbeToTracker", tracked.reference_from_image.matrix(), TrackingStatus::kOk});
    io::set_transform(frame,
                      {"ReferenceToTracker", Eigen::Matrix4d::Identity(), TrackingStatus::kOk});
    io::set_transform(
        frame, {"ImageToProbe", app::image_from_pixels(tracked.frame.grid), TrackingStatus::kOk});
    if (const auto written = writer->append(frame); !written) return written.error();
  }
  return writer->finish();
}

/// The program sonde beside this one.
std::string program_beside() {
  std::error_code none;
  return std::filesystem::read_symlink("/proc/self/exe", none).parent_path() / "sonde";
}

std::string words_of(const Eigen::Matrix4d& matrix) {
  std::ostringstream text;
  text << std::setprecision(17);
  for (int i = 0; i < 16; ++i) text << (i > 0 ? " " : "") << matrix(i / 4, i % 4);
  return text.str();
}

}  // namespace

Result<CommandRun> register_by_command(const Sweep& sweep, const std::filesystem::path& ct,
                                       const CtPose& start, registration::Effort effort,
                                       const std::filesystem::path& folder) {
  const std::filesystem::path recording = folder / "sweep.mha";
  const std::filesystem::path report = folder / "report.json";
  if (const auto written = write_recording(sweep, recording); !written) return written.error();
  const auto run = run_program(
      {program_beside(), "register", recording.string(), "--ct", ct.string(),
       "--accept-unknown-orientation", "--ct-from-reference", words_of(start.matrix()), "--effort",
       registration::to_string(effort), "--threads", "1", "--json", report.string()});
  std::ifstream in(report);
  const io::Json json = io::Json::parse(in, nullptr, false);
  const auto reject = [&](const std::string& found) {
    return Error{ErrorCode::kRefused,
                 "sonde register of " + recording.string() + ": expected a report, found " + found};
  };
  if (!run) return reject("no process");
  const io::Json registration =
      json.is_object() ? json.value("registration", io::Json()) : io::Json();
  // The bench judges refused ones too.
  io::Json pose_json;
  for (const char* key : {session::kAcceptedPose, session::kRefusedPose}) {
    if (registration.contains(key)) pose_json = registration.at(key);
  }
  if (pose_json.is_null()) return reject("exit code " + std::to_string(run->exit_code));
  const auto numbers = pose_json.get<std::vector<double>>();
  Eigen::Matrix4d matrix;
  if (numbers.size() != 16) return reject("no matrix");
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = numbers[static_cast<std::size_t>(i)];
  const auto pose = rigid_from_matrix<frames::Ct, frames::Reference>(matrix);
  if (!pose) return pose.error();
  return CommandRun{*pose, run->cpu_s};
}

}  // namespace nav::bench
