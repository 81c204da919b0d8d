// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Runs a fuzzer of this folder without libFuzzer, by any compiler: so many inputs, each a changed
// file of a corpus, the same ones for the same seed. What it prints goes nowhere; an input that
// ends the process stays in a file.
//   NAME_fuzz_runs CORPUS RUNS SEED
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <unistd.h>
#include <vector>

extern "C" {
int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                    unsigned seed);
__attribute__((weak)) void __sanitizer_set_report_fd(void* fd);
}

namespace {

constexpr std::size_t kMostBytes = 65536;
constexpr unsigned kByteSeed = 12345;

std::minstd_rand& byte_engine() {
  static std::minstd_rand engine(kByteSeed);
  return engine;
}

std::size_t below(std::size_t count) {
  return std::uniform_int_distribution<std::size_t>(0, count - 1)(byte_engine());
}

std::array<std::uint8_t, kMostBytes> current;
std::size_t current_size = 0;
char crash_file[64];
int report_fd = 2;

/// Keeps the input that ends the process. Calls only what a signal handler may call.
void keep_input(int signal) {
  const int file = ::open(crash_file, O_CREAT | O_WRONLY | O_TRUNC, 0600);
  if (file >= 0) {
    (void)!::write(file, current.data(), current_size);
    ::close(file);
  }
  (void)!::write(report_fd, crash_file, std::strlen(crash_file));
  (void)!::write(report_fd, "\n", 1);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

/// The changes of bytes that libFuzzer would make.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most) {
  std::string bytes(reinterpret_cast<const char*>(data), size);
  for (std::size_t left = 1 + below(4); left > 0 && !bytes.empty(); --left) {
    const std::size_t at = below(bytes.size());
    const std::size_t length = std::min(1 + below(20), bytes.size() - at);
    switch (below(5)) {
      case 0:
        bytes[at] = static_cast<char>(below(256));
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 2:
        bytes.erase(at, length);
        break;
      case 3:
        bytes.insert(at, bytes.substr(at, length));
        break;
      default:
        bytes.resize(at);
    }
  }
  const std::size_t kept = std::min(bytes.size(), most);
  std::memcpy(data, bytes.data(), kept);
  return kept;
}

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "expected a corpus, a number of runs and a seed\n");
    return 2;
  }
  std::vector<std::string> corpus;
  for (const auto& file : std::filesystem::directory_iterator(argv[1])) {
    std::ifstream in(file.path(), std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  std::ranges::sort(corpus);  // Folders have no order.
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: expected files, found none\n", argv[1]);
    return 2;
  }
  const long runs = std::strtol(argv[2], nullptr, 10);
  const auto seed = static_cast<unsigned>(std::strtoul(argv[3], nullptr, 10));
  std::minstd_rand engine(seed);
  byte_engine().seed(seed);
  std::snprintf(crash_file, sizeof crash_file, "fuzz-crash-%d", static_cast<int>(::getpid()));
  report_fd = ::dup(2);
  if (__sanitizer_set_report_fd != nullptr) {
    __sanitizer_set_report_fd(reinterpret_cast<void*>(static_cast<std::intptr_t>(report_fd)));
  }
  const int nowhere = ::open("/dev/null", O_WRONLY);
  ::dup2(nowhere, 1);
  ::dup2(nowhere, 2);
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL}) {
    std::signal(signal, keep_input);
  }
  for (long run = 0; run < runs; ++run) {
    const std::string& file =
        corpus[std::uniform_int_distribution<std::size_t>(0, corpus.size() - 1)(engine)];
    current_size = std::min(file.size(), kMostBytes);
    std::memcpy(current.data(), file.data(), current_size);
    for (auto left = 1 + engine() % 3; left > 0; --left) {
      current_size = LLVMFuzzerCustomMutator(current.data(), current_size, kMostBytes,
                                             static_cast<unsigned>(engine()));
    }
    LLVMFuzzerTestOneInput(current.data(), current_size);
  }
  ::dprintf(report_fd, "%ld inputs, no findings\n", runs);
  return 0;
}
