// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/serial_port.hpp"

#include <cerrno>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <system_error>
#include <termios.h>
#include <unistd.h>

#include "devices/ndi/serial_speed.hpp"

namespace nav::devices {
namespace {

TcpFailure serial_failure(int error) {
  switch (error) {
    case ENOENT:
      return {"absent", "expected a serial port, found no such file; plug it in"};
    case EACCES:
    case EPERM:
      return {
          "permission",
          "expected to be readable, found permission denied; add the user to the group dialout"};
    case EBUSY:
      return {"busy", "another program uses it; close that program"};
    case ENOTTY:
    case EISDIR:
      return {"not_serial", "expected a serial port, found another kind of file"};
    case EIO:
    case ENODEV:
    case ENXIO:
      return {"unplugged", "it was unplugged"};
    default:
      return {"error", std::generic_category().message(error)};
  }
}

int make_raw(int fd) {
  termios settings{};
  if (::tcgetattr(fd, &settings) != 0) return errno;
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  return ::tcsetattr(fd, TCSANOW, &settings) == 0 ? 0 : errno;
}

}  // namespace

std::optional<TcpFailure> SerialPort::open(const std::string& path, int baud) {
  close();
  FileDescriptor fd(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!fd.is_open()) return serial_failure(errno);
  if (::isatty(fd.get()) == 0) return serial_failure(ENOTTY);
  if (::ioctl(fd.get(), TIOCEXCL) != 0) return serial_failure(errno);
  fd_ = std::move(fd);
  if (const int error = make_raw(fd_.get()); error != 0) {
    close();
    return serial_failure(error);
  }
  if (auto failure = set_baud(baud)) {
    close();
    return failure;
  }
  // Lines that an adapter does not have are not needed.
  int lines = TIOCM_DTR | TIOCM_RTS;
  (void)::ioctl(fd_.get(), TIOCMBIS, &lines);
  (void)::tcflush(fd_.get(), TCIOFLUSH);
  return std::nullopt;
}

void SerialPort::close() noexcept {
  if (!fd_.is_open()) return;
  // Bytes that were not sent must not hold up closing it.
  (void)::tcflush(fd_.get(), TCIOFLUSH);
  (void)::ioctl(fd_.get(), TIOCNXCL);
  fd_.close();
}

std::optional<TcpFailure> SerialPort::set_baud(int baud) {
  if (const int error = set_serial_speed(fd_.get(), baud); error != 0) {
    return serial_failure(error);
  }
  return std::nullopt;
}

void SerialPort::set_break(bool on) noexcept { (void)::ioctl(fd_.get(), on ? TIOCSBRK : TIOCCBRK); }

TcpTransfer SerialPort::receive(std::span<std::byte> into) {
  const ssize_t count = ::read(fd_.get(), into.data(), into.size());
  if (count > 0) return {static_cast<std::size_t>(count)};
  if (count == 0) return {0, serial_failure(ENODEV)};
  if (errno == EAGAIN || errno == EINTR) return {};
  return {0, serial_failure(errno)};
}

TcpTransfer SerialPort::send(std::span<const std::byte> from) {
  const ssize_t count = ::write(fd_.get(), from.data(), from.size());
  if (count >= 0) return {static_cast<std::size_t>(count)};
  if (errno == EAGAIN || errno == EINTR) return {};
  return {0, serial_failure(errno)};
}

}  // namespace nav::devices
