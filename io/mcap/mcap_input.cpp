// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/mcap_input.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "io/detail/input_file.hpp"
#include "nav/check.hpp"

namespace nav::io::mcap {
namespace {

class FileInput final : public Input {
 public:
  explicit FileInput(detail::InputFile file)
      : file_(std::move(file)), name_(file_.path().string()) {}
  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] std::uint64_t size() const override {
    return static_cast<std::uint64_t>(file_.size());
  }
  [[nodiscard]] Result<std::size_t> read_at(std::uint64_t offset,
                                            std::span<std::byte> out) const override {
    return file_.read_at(static_cast<std::int64_t>(offset), out);
  }

 private:
  detail::InputFile file_;
  std::string name_;
};

class MemoryInput final : public Input {
 public:
  MemoryInput(std::string name, std::span<const std::byte> bytes)
      : name_(std::move(name)), bytes_(bytes) {}
  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] Result<std::size_t> read_at(std::uint64_t offset,
                                            std::span<std::byte> out) const override {
    if (offset >= bytes_.size()) return std::size_t{0};
    const auto from = bytes_.subspan(static_cast<std::size_t>(offset));
    const std::size_t count = std::min(out.size(), from.size());
    if (count > 0) std::memcpy(out.data(), from.data(), count);
    return count;
  }

 private:
  std::string name_;
  std::span<const std::byte> bytes_;
};

}  // namespace

Result<std::shared_ptr<const Input>> open_input(const std::filesystem::path& path) {
  auto file = detail::InputFile::open(path);
  if (!file) return file.error();
  return std::shared_ptr<const Input>(std::make_shared<FileInput>(*std::move(file)));
}

std::shared_ptr<const Input> memory_input(std::string name, std::span<const std::byte> bytes) {
  return std::make_shared<MemoryInput>(std::move(name), bytes);
}

Result<std::span<const std::byte>> Window::peek(std::uint64_t offset, std::size_t count) {
  const auto some = peek_some(offset, count);
  if (!some) return some;
  return some->first(std::min(count, some->size()));
}

Result<std::span<const std::byte>> Window::peek_some(std::uint64_t offset, std::size_t count) {
  NAV_CHECK(count <= kBytes, count);
  const bool inside = offset >= start_ && offset - start_ <= filled_;
  const std::size_t skipped = inside ? static_cast<std::size_t>(offset - start_) : 0;
  const bool at_end = start_ + filled_ >= input_->size();
  if (inside && filled_ > 0 && (at_end || filled_ - skipped >= count)) {
    return std::span<const std::byte>(bytes_).subspan(skipped, filled_ - skipped);
  }
  bytes_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kBytes, input_->size())));
  filled_ = 0;
  const auto got = input_->read_at(offset, bytes_);
  if (!got) return got.error();
  start_ = offset;
  filled_ = *got;
  return std::span<const std::byte>(bytes_).first(filled_);
}

}  // namespace nav::io::mcap
