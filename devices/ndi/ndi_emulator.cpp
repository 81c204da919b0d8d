// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_emulator.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <sys/socket.h>
#include <system_error>
#include <termios.h>
#include <unistd.h>

#include "devices/ndi/ndi_encode.hpp"

namespace nav::devices {
namespace {

constexpr std::size_t kLongestCommand = 4096;
constexpr Duration kIdle = std::chrono::hours(1);

Error unavailable(const std::string& what) {
  return {ErrorCode::kUnavailable,
          "NDI emulator: cannot " + what + ": " + std::generic_category().message(errno)};
}

/// No echo and no translation, also before a client has set its own.
void make_terminal_raw(int fd) {
  termios settings{};
  if (::tcgetattr(fd, &settings) != 0) return;
  ::cfmakeraw(&settings);
  (void)::tcsetattr(fd, TCSANOW, &settings);
}

}  // namespace

Result<std::unique_ptr<NdiEmulator>> NdiEmulator::start(NdiEmulatedOptions options,
                                                        NdiEmulatorLine line, NdiFaultPlan plan) {
  std::unique_ptr<NdiEmulator> emulator(
      new NdiEmulator(std::move(options), std::move(line), std::move(plan)));
  if (auto ok = emulator->open(); !ok) return ok.error();
  emulator->thread_ = std::thread([raw = emulator.get()] { raw->run(); });
  return emulator;
}

NdiEmulator::NdiEmulator(NdiEmulatedOptions options, NdiEmulatorLine line, NdiFaultPlan plan)
    : line_(std::move(line)),
      plan_(std::move(plan)),
      tracker_(std::move(options)),
      random_(plan_.seed) {}

NdiEmulator::~NdiEmulator() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  wake_.signal();
  if (thread_.joinable()) thread_.join();
  close();
}

Result<void> NdiEmulator::open() {
  if (!line_.tcp) return open_terminal();
  auto address = resolve_tcp("127.0.0.1", line_.port);
  if (!address) return address.error();
  auto listener = listen_tcp(*address);
  if (!listener) return listener.error();
  listener_ = *std::move(listener);
  line_.port = bound_port(listener_);
  return {};
}

Result<void> NdiEmulator::open_terminal() {
  FileDescriptor master(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!master.is_open()) return unavailable("open a pseudo terminal");
  std::array<char, 128> name{};
  if (::grantpt(master.get()) != 0 || ::unlockpt(master.get()) != 0 ||
      ::ptsname_r(master.get(), name.data(), name.size()) != 0) {
    return unavailable("unlock a pseudo terminal");
  }
  slave_ = FileDescriptor(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (!slave_.is_open()) return unavailable("open the other side of a pseudo terminal");
  make_terminal_raw(slave_.get());
  peer_ = std::move(master);
  path_ = name.data();
  if (line_.link.empty()) return {};
  std::error_code error;
  if (std::filesystem::exists(std::filesystem::symlink_status(line_.link, error))) {
    // A link to a terminal may be left of a run that was killed; all else is somebody's.
    const auto target = std::filesystem::read_symlink(line_.link, error);
    if (error || target.parent_path() != "/dev/pts") {
      return Error{ErrorCode::kIo, line_.link.string() +
                                       ": expected a name that does not exist, or a link to a "
                                       "terminal, found a file of another kind"};
    }
    std::filesystem::remove(line_.link, error);
  }
  std::filesystem::create_symlink(path_, line_.link, error);
  if (error) {
    return Error{ErrorCode::kUnavailable,
                 line_.link.string() + ": cannot be made: " + error.message()};
  }
  terminal_ = path_;
  path_ = line_.link.string();
  return {};
}

void NdiEmulator::close() {
  if (std::error_code error; !terminal_.empty()) {
    const auto target = std::filesystem::read_symlink(line_.link, error);
    if (!error && target == terminal_) std::filesystem::remove(line_.link, error);
    terminal_.clear();
  }
  listener_.close();
  peer_.close();
  slave_.close();
  received_.clear();
  unsent_.clear();
}

std::string NdiEmulator::path() const {
  const std::lock_guard lock(mutex_);
  return path_;
}

std::uint16_t NdiEmulator::port() const {
  const std::lock_guard lock(mutex_);
  return line_.port;
}

void NdiEmulator::inject(NdiEmulatedFault fault, std::size_t replies) {
  const std::lock_guard lock(mutex_);
  injected_.insert(injected_.end(), replies, fault);
}

std::size_t NdiEmulator::injected() const {
  const std::lock_guard lock(mutex_);
  return injected_.size();
}

void NdiEmulator::plug(std::size_t tool, bool in) {
  const std::lock_guard lock(mutex_);
  tracker_.plug(tool, in);
}

void NdiEmulator::reset() {
  const std::lock_guard lock(mutex_);
  send(tracker_.reset());
  wake_.signal();
}

void NdiEmulator::unplug() {
  const std::lock_guard lock(mutex_);
  (void)tracker_.reset();
  close();
  wake_.signal();
}

Result<void> NdiEmulator::replug() {
  const std::lock_guard lock(mutex_);
  auto ok = open();
  wake_.signal();
  return ok;
}

std::uint64_t NdiEmulator::commands() const {
  const std::lock_guard lock(mutex_);
  return commands_;
}

void NdiEmulator::run() {
  for (;;) {
    std::array<Watched, 3> watched{};
    {
      const std::lock_guard lock(mutex_);
      if (stopped_) return;
      watched = {Watched{.fd = wake_.get(), .read = true},
                 Watched{.fd = listener_.get(), .read = true},
                 Watched{.fd = peer_.get(), .read = true, .write = !unsent_.empty()}};
    }
    wait_for(watched, kIdle);
    wake_.clear();
    const std::lock_guard lock(mutex_);
    if (watched[1].read && listener_.get() == watched[1].fd && listener_.is_open()) {
      FileDescriptor client(
          ::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (client.is_open()) {
        peer_ = std::move(client);
        received_.clear();
        unsent_.clear();
        continue;
      }
    }
    if (!peer_.is_open() || peer_.get() != watched[2].fd) continue;
    if (watched[2].read) take_bytes();
    flush();
  }
}

void NdiEmulator::take_bytes() {
  std::array<char, 4096> bytes{};
  const ssize_t count = ::read(peer_.get(), bytes.data(), bytes.size());
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count <= 0) {
    peer_.close();
    return;
  }
  received_.append(bytes.data(), static_cast<std::size_t>(count));
  for (auto end = received_.find('\r'); end != std::string::npos; end = received_.find('\r')) {
    const std::string command = received_.substr(0, end);
    received_.erase(0, end + 1);
    answer(command);
  }
  if (received_.size() > kLongestCommand) received_.clear();
}

void NdiEmulator::answer(std::string_view command) {
  ++commands_;
  std::optional<NdiEmulatedFault> fault;
  const bool asks_for_poses = tracker_.is_tracking();
  if (!injected_.empty()) {
    fault = injected_.front();
    injected_.erase(injected_.begin());
  } else if (asks_for_poses && !plan_.kinds.empty() &&
             std::uniform_real_distribution<double>(0, 1)(random_) < plan_.rate) {
    fault = plan_.kinds[random_() % plan_.kinds.size()];
  }
  if (fault == NdiEmulatedFault::kReset) return send(tracker_.reset());
  if (fault == NdiEmulatedFault::kRepeat) tracker_.hold_number();
  std::vector<std::byte> reply = tracker_.answer(command);
  const auto half = static_cast<std::ptrdiff_t>(reply.size() / 2);
  if (fault == NdiEmulatedFault::kSilence) return;
  if (fault == NdiEmulatedFault::kBadCrc) reply[reply.size() / 2] ^= std::byte{1};
  if (fault == NdiEmulatedFault::kTruncated) reply.resize(reply.size() / 2);
  if (fault == NdiEmulatedFault::kGarbage) {
    std::vector<std::byte> garbage(1 + random_() % 40);
    for (std::byte& byte : garbage) byte = static_cast<std::byte>(random_());
    reply.insert(reply.begin(), garbage.begin(), garbage.end());
  }
  if (fault == NdiEmulatedFault::kSplit) {
    constexpr Duration kBetween = std::chrono::milliseconds(5);
    send({reply.begin(), reply.begin() + half});
    std::this_thread::sleep_for(kBetween);
    reply.erase(reply.begin(), reply.begin() + half);
  }
  send(std::move(reply));
}

void NdiEmulator::send(std::vector<std::byte> reply) {
  unsent_.insert(unsent_.end(), reply.begin(), reply.end());
  flush();
}

void NdiEmulator::flush() {
  while (!unsent_.empty() && peer_.is_open()) {
    const ssize_t count = line_.tcp
                              ? ::send(peer_.get(), unsent_.data(), unsent_.size(), MSG_NOSIGNAL)
                              : ::write(peer_.get(), unsent_.data(), unsent_.size());
    if (count <= 0) {
      if (errno != EAGAIN && errno != EINTR) unsent_.clear();
      return;
    }
    unsent_.erase(unsent_.begin(), unsent_.begin() + count);
  }
}

}  // namespace nav::devices
