// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// JSON: the checked reader, files of scan lines, registrations and arms.
#include "io/json_member.hpp"
#include "io/scan_line_file.hpp"
#include "nav/volume.hpp"
#include "session/arm_file.hpp"
#include "session/registration_file.hpp"
#include "tests/fuzz/fuzz_input.hpp"
#include "tests/fuzz/fuzz_mutation.hpp"

namespace {

const nav::Volume& small_ct() {
  static const nav::Volume ct = [] {
    nav::VoxelGrid grid;
    grid.size = {2, 2, 2};
    return *nav::Volume::create(grid, std::vector<std::int16_t>(8, 0), "small");
  }();
  return ct;
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  return nav::fuzz::mutate_json(data, size, most, seed);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  const auto json =
      io::parse_json("a.json", std::string(reinterpret_cast<const char*>(bytes), size));
  if (!json) fuzz::check_message(json.error().message);
  const auto file = fuzz::as_file(bytes, size, "a.json");
  const auto lines = io::read_scan_line_file(file);
  if (!lines) fuzz::check_message(lines.error().message);
  const auto registration = session::read_registration(file, small_ct(), {"Reference", false});
  if (!registration) fuzz::check_message(registration.error().message);
  const auto alone = session::read_registration(file);
  if (!alone) fuzz::check_message(alone.error().message);
  const auto arm = session::read_arm_file(file);
  if (!arm) fuzz::check_message(arm.error().message);
  return 0;
}
