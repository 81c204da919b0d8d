// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_transport.hpp"

#include "devices/ndi/serial_port.hpp"

namespace nav::devices {
namespace {

class NdiSerial final : public NdiTransport {
 public:
  explicit NdiSerial(std::string path) : path_(std::move(path)) {}
  [[nodiscard]] const std::string& name() const override { return path_; }
  [[nodiscard]] bool is_serial() const override { return true; }
  std::optional<TcpFailure> open() override {
    constexpr int kAfterReset = 9600;
    return port_.open(path_, kAfterReset);
  }
  std::optional<TcpFailure> finish() override { return std::nullopt; }
  void close() noexcept override { port_.close(); }
  [[nodiscard]] int descriptor() const override { return port_.descriptor(); }
  TcpTransfer receive(std::span<std::byte> into) override { return port_.receive(into); }
  TcpTransfer send(std::span<const std::byte> from) override { return port_.send(from); }
  std::optional<TcpFailure> set_baud(int baud) override { return port_.set_baud(baud); }
  void set_break(bool on) noexcept override { port_.set_break(on); }

 private:
  std::string path_;
  SerialPort port_;
};

class NdiTcp final : public NdiTransport {
 public:
  explicit NdiTcp(TcpEndpoint peer) : peer_(std::move(peer)) {}
  [[nodiscard]] const std::string& name() const override { return peer_.text; }
  [[nodiscard]] bool is_serial() const override { return false; }
  std::optional<TcpFailure> open() override {
    auto begun = begin_tcp_connect(peer_);
    if (!begun) return TcpFailure{"error", begun.error().message};
    socket_ = *std::move(begun);
    return std::nullopt;
  }
  std::optional<TcpFailure> finish() override { return finish_tcp_connect(socket_); }
  void close() noexcept override { socket_.close(); }
  [[nodiscard]] int descriptor() const override { return socket_.get(); }
  TcpTransfer receive(std::span<std::byte> into) override { return receive_now(socket_, into); }
  TcpTransfer send(std::span<const std::byte> from) override { return send_now(socket_, from); }
  std::optional<TcpFailure> set_baud(int /*baud*/) override { return std::nullopt; }
  void set_break(bool /*on*/) noexcept override {}

 private:
  TcpEndpoint peer_;
  FileDescriptor socket_;
};

}  // namespace

std::unique_ptr<NdiTransport> make_ndi_serial(const std::string& path) {
  return std::make_unique<NdiSerial>(path);
}

Result<std::unique_ptr<NdiTransport>> make_ndi_tcp(const std::string& host, std::uint16_t port) {
  auto peer = resolve_tcp(host, port);
  if (!peer) return peer.error();
  return std::unique_ptr<NdiTransport>(std::make_unique<NdiTcp>(*std::move(peer)));
}

}  // namespace nav::devices
