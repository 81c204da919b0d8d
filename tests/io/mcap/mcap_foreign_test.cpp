// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "tests/io/mcap/mcap_damage.hpp"

namespace nav::test {
namespace {

/// Output and exit code of a command.
std::pair<std::string, int> output_of(const std::string& command) {
  FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return {"", 127};
  std::string output;
  std::array<char, 4096> part{};
  while (const std::size_t got = std::fread(part.data(), 1, part.size(), pipe)) {
    output.append(part.data(), got);
  }
  const int status = ::pclose(pipe);
  return {output, WIFEXITED(status) ? WEXITSTATUS(status) : 128};
}

/// A reader that knows nothing of Sonde, with checksums on.
TEST(McapForeignTest, TheReaderOfTheMcapProjectReadsTheSame) {
  const char* folder = std::getenv("SONDE_NODE_FOLDER");
  if (!folder) {
    GTEST_SKIP() << "SONDE_NODE_FOLDER is not set: run `npm install @mcap/core` in a folder, and "
                    "name it by this variable";
  }
  const TemporaryFolder here;
  put(here / "a.mcap", small_recording());
  const std::string script =
      std::string(SONDE_SOURCE_DIR) + "/tests/io/mcap/mcap_foreign_reader.mjs";
  const auto [text, code] =
      output_of("node '" + script + "' '" + folder + "' '" + (here / "a.mcap").string() + "'");
  if (code == 127) GTEST_SKIP() << "node is not installed";
  if (code == 3) GTEST_SKIP() << "@mcap/core is not installed in " << folder;
  ASSERT_EQ(code, 0) << text;
  const auto found = nlohmann::json::parse(text);
  std::uint64_t publish = 0, sequence = 0;
  std::map<std::string, int> counts;
  for (const DeviceSample& next : small_session(200)) {
    const Sample& sample = next.sample;
    const bool missing = std::holds_alternative<MissingImage>(sample.what);
    ++counts[next.device == 0 ? (sample.stream == 0 ? "/tracker/Probe" : "/tracker/Needle_1")
                              : (missing ? "/scanner/Image/missing" : "/scanner/Image")];
    const std::int64_t ns = sample.device_time ? sample.device_time->time_since_epoch().count()
                                               : sample.received.time_since_epoch().count();
    publish += static_cast<std::uint64_t>(std::max<std::int64_t>(ns, 0));
    sequence += sample.sequence;
  }
  const auto samples = small_session(200);
  const auto time_of = [](const DeviceSample& next) {
    return std::to_string(next.sample.received.time_since_epoch().count());
  };
  EXPECT_EQ(found["counts"], nlohmann::json(counts));
  EXPECT_EQ(found["first"], time_of(samples.front()));
  EXPECT_EQ(found["last"], time_of(samples.back()));
  EXPECT_EQ(found["publish"], std::to_string(publish));
  EXPECT_EQ(found["sequence"], sequence);
  EXPECT_EQ(found["statistics"], "200");
  EXPECT_EQ(found["streamed"], 200);
  EXPECT_EQ(found["stream_done"], true);
  EXPECT_EQ(found["data_crc_holds"], true);
  EXPECT_EQ(found["attachments"], nlohmann::json({"c text/xml 11"}));
  EXPECT_EQ(found["metadata"], nlohmann::json({"sonde.session", "end"}));
}

}  // namespace
}  // namespace nav::test
