// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/mcap_writer.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <limits>
#include <sys/stat.h>
#include <unistd.h>

#include "io/mcap/mcap_bytes.hpp"
#include "io/mcap/mcap_crc.hpp"
#include "nav/check.hpp"

namespace nav::io::mcap {
namespace {

constexpr std::size_t kChunkPrefix = kPrefixBytes + kChunkHeadBytes;

bool is_special_file(const std::filesystem::path& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

}  // namespace

Result<void> validate(const WriterOptions& options) {
  if (options.chunk_bytes < 1 || options.chunk_bytes > kMaxChunkLimit) {
    return Error{ErrorCode::kUsage, "chunk_bytes: expected 1 to " + std::to_string(kMaxChunkLimit) +
                                        ", found " + std::to_string(options.chunk_bytes)};
  }
  if (options.chunk_time < Duration(1) || options.chunk_time > std::chrono::hours(1)) {
    return Error{ErrorCode::kUsage, "chunk_time: expected 1 ns to 1 h, found " +
                                        std::to_string(options.chunk_time.count()) + " ns"};
  }
  return {};
}

Writer::Descriptor::~Descriptor() { close(); }

int Writer::Descriptor::close() {
  if (value_ < 0) return 0;
  return ::close(std::exchange(value_, -1)) == 0 ? 0 : errno;
}

Result<Writer> Writer::create(const std::filesystem::path& path, const WriterOptions& options) {
  if (auto ok = validate(options); !ok) return ok.error();
  const bool is_special = is_special_file(path);
  const int how = is_special ? O_WRONLY : O_WRONLY | O_CREAT | O_EXCL;
  const int descriptor = ::open(path.c_str(), how | O_CLOEXEC, 0644);
  if (descriptor < 0) {
    const int reason = errno;
    return Error{ErrorCode::kIo,
                 path.string() + (reason == EEXIST
                                      ? ": expected a new file, found an existing one"
                                      : std::string(": cannot create: ") + std::strerror(reason))};
  }
  auto writer = adopt(descriptor, path.string(), options);
  // Otherwise the name would be taken by a file without any content.
  if (!writer && !is_special) ::unlink(path.c_str());
  return writer;
}

Result<Writer> Writer::adopt(int descriptor, std::string name, const WriterOptions& options) {
  Writer writer;
  writer.descriptor_ = Descriptor(descriptor);
  writer.name_ = std::move(name);
  writer.options_ = options;
  if (auto ok = validate(options); !ok) return ok.error();
  Buffer start(kMagic.begin(), kMagic.end());
  append(start, Header{options.profile, options.library});
  if (auto ok = writer.put_record(start); !ok) return ok.error();
  return writer;
}

Result<void> Writer::usable() const {
  if (stopped_) return *stopped_;
  NAV_CHECK(descriptor_.get() >= 0, name_);
  return {};
}

/// Remembers why nothing more can be written, and cuts the file behind its last whole record.
Error Writer::stop(int reason, std::uint64_t record_start) {
  stopped_ = Error{ErrorCode::kIo, name_ + ": expected to write at byte " + std::to_string(size_) +
                                       ", found: " + std::strerror(reason)};
  // Fails for a pipe, which cannot be cut.
  if (::ftruncate(descriptor_.get(), static_cast<off_t>(record_start)) == 0) size_ = record_start;
  return *stopped_;
}

/// Writes bytes. \p record_start: offset of the record that they belong to.
Result<void> Writer::put(std::span<const std::byte> bytes, std::uint64_t record_start) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor_.get(), bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return stop(done < 0 ? errno : EIO, record_start);
    size_ += static_cast<std::uint64_t>(done);
    bytes = bytes.subspan(static_cast<std::size_t>(done));
  }
  return {};
}

/// Writes a small record of the data section.
Result<void> Writer::put_record(const Buffer& record) {
  data_crc_ = crc32_of(record, data_crc_);
  return put(record, size_);
}

/// Takes the record at the end of \p records into the open chunk; \p before: its start.
Result<void> Writer::repeat_in_chunks(Buffer& records, std::size_t before) {
  constexpr std::size_t kMostIds = std::numeric_limits<std::uint16_t>::max();
  if (schemas_.size() + channels_.size() > kMaxPreambleBytes || statistics_.schemas >= kMostIds ||
      counts_.size() >= kMostIds) {
    records.resize(before);
    return Error{ErrorCode::kUsage, name_ + ": expected at most " + std::to_string(kMostIds) +
                                        " schemas and channels in " +
                                        std::to_string(kMaxPreambleBytes) + " bytes, found more"};
  }
  if (!chunk_.empty()) {
    chunk_.insert(chunk_.end(), records.begin() + static_cast<std::ptrdiff_t>(before),
                  records.end());
  }
  return {};
}

Result<std::uint16_t> Writer::add_schema(Schema record) {
  if (auto ok = usable(); !ok) return ok.error();
  record.id = static_cast<std::uint16_t>(statistics_.schemas + 1);
  const std::size_t before = schemas_.size();
  append(schemas_, record);
  if (auto ok = repeat_in_chunks(schemas_, before); !ok) return ok.error();
  ++statistics_.schemas;
  return record.id;
}

Result<std::uint16_t> Writer::add_channel(Channel record) {
  if (auto ok = usable(); !ok) return ok.error();
  if (record.schema > statistics_.schemas) {
    return Error{ErrorCode::kUsage, name_ + ": channel " + record.topic +
                                        ": expected a known schema, found number " +
                                        std::to_string(record.schema)};
  }
  record.id = static_cast<std::uint16_t>(counts_.size());
  const std::size_t before = channels_.size();
  append(channels_, record);
  if (auto ok = repeat_in_chunks(channels_, before); !ok) return ok.error();
  ++statistics_.channels;
  counts_.push_back(0);
  open_messages_.emplace_back();
  return record.id;
}

/// Ends the chunk that is full in time, and begins one if there is none.
Result<void> Writer::make_ready(std::uint64_t log_time) {
  if (auto ok = advance_to(log_time); !ok) return ok;
  if (!chunk_.empty()) return {};
  chunk_.resize(kChunkPrefix);
  chunk_.insert(chunk_.end(), schemas_.begin(), schemas_.end());
  chunk_.insert(chunk_.end(), channels_.begin(), channels_.end());
  chunk_start_ = chunk_end_ = log_time;
  return {};
}

void Writer::note(const MessageHead& head) {
  open_messages_[head.channel].push_back({head.log_time, chunk_.size() - kChunkPrefix});
  chunk_start_ = std::min(chunk_start_, head.log_time);
  chunk_end_ = std::max(chunk_end_, head.log_time);
  const bool first = statistics_.messages++ == 0;
  statistics_.start_time = first ? head.log_time : std::min(statistics_.start_time, head.log_time);
  statistics_.end_time = std::max(statistics_.end_time, head.log_time);
  ++counts_[head.channel];
}

Result<void> Writer::write(const MessageHead& head, std::span<const std::byte> data,
                           std::span<const std::byte> more) {
  if (auto ok = usable(); !ok) return ok;
  const std::size_t bytes = data.size() + more.size();
  if (head.channel >= counts_.size() || bytes > kMaxMessageBytes) {
    return Error{ErrorCode::kUsage, name_ + ": expected a known channel and at most " +
                                        std::to_string(kMaxMessageBytes) +
                                        " bytes, found channel " + std::to_string(head.channel) +
                                        " and " + std::to_string(bytes) + " bytes"};
  }
  if (auto ok = make_ready(head.log_time); !ok) return ok;
  note(head);
  append(chunk_, head, bytes);
  chunk_.insert(chunk_.end(), data.begin(), data.end());
  chunk_.insert(chunk_.end(), more.begin(), more.end());
  return chunk_.size() - kChunkPrefix >= options_.chunk_bytes ? flush() : Result<void>{};
}

Result<void> Writer::advance_to(std::uint64_t log_time) {
  if (auto ok = usable(); !ok) return ok;
  const auto limit = static_cast<std::uint64_t>(options_.chunk_time.count());
  const bool over = !chunk_.empty() && log_time > chunk_start_ && log_time - chunk_start_ >= limit;
  return over ? flush() : Result<void>{};
}

/// Appends the indexes of the open chunk behind its records, and fills entry_.
void Writer::append_message_indexes(std::size_t records_end) {
  entry_.start_time = chunk_start_;
  entry_.end_time = chunk_end_;
  entry_.offset = size_;
  entry_.length = records_end;
  entry_.compressed_bytes = entry_.uncompressed_bytes = records_end - kChunkPrefix;
  entry_.message_indexes.clear();
  for (std::size_t channel = 0; channel < open_messages_.size(); ++channel) {
    auto& messages = open_messages_[channel];
    if (messages.empty()) continue;
    const auto id = static_cast<std::uint16_t>(channel);
    entry_.message_indexes.emplace_back(id, size_ + chunk_.size());
    append_message_index(chunk_, id, messages);
    messages.clear();
  }
  entry_.message_index_bytes = chunk_.size() - records_end;
}

void Writer::forget_chunk() {
  chunk_.clear();
  for (auto& messages : open_messages_) messages.clear();
}

Result<void> Writer::flush() {
  if (auto ok = usable(); !ok) return ok;
  if (chunk_.empty()) return {};
  const std::size_t records_end = chunk_.size();
  const auto records = std::span(chunk_).subspan(kChunkPrefix);
  const std::uint32_t crc = crc32_of(records);
  const std::uint64_t bytes = records.size();
  scratch_.clear();
  append(scratch_, ChunkHead{.start_time = chunk_start_,
                             .end_time = chunk_end_,
                             .uncompressed_bytes = bytes,
                             .crc = crc,
                             .compression = {},
                             .records_bytes = bytes});
  std::copy(scratch_.begin(), scratch_.end(), chunk_.begin());
  append_message_indexes(records_end);
  data_crc_ = crc32_joined(crc32_of(scratch_, data_crc_), crc, bytes);
  data_crc_ = crc32_of(std::span(chunk_).subspan(records_end), data_crc_);
  const auto ok = put(chunk_, size_);
  if (ok) {
    append(chunk_indexes_, entry_);
    ++statistics_.chunks;
  }
  forget_chunk();
  return ok;
}

Result<void> Writer::attach(AttachmentHead head, std::span<const std::byte> data) {
  if (auto ok = usable(); !ok) return ok;
  head.data_bytes = data.size();
  const std::uint64_t start = size_;
  Buffer record;
  append(record, head);
  const std::uint64_t length = record.size() + data.size() + 4;
  const std::uint32_t crc =
      crc32_of(data, crc32_of(std::span<const std::byte>(record).subspan(kPrefixBytes)));
  Buffer end;
  ByteWriter(end).number(crc);
  for (const std::span<const std::byte> part :
       {std::span<const std::byte>(record), data, std::span<const std::byte>(end)}) {
    data_crc_ = crc32_of(part, data_crc_);
    if (auto ok = put(part, start); !ok) return ok;
  }
  append(attachment_indexes_, AttachmentIndex{start, length, std::move(head)});
  ++statistics_.attachments;
  return {};
}

Result<void> Writer::add_metadata(Metadata record) {
  if (auto ok = usable(); !ok) return ok;
  record = with_checksum(std::move(record));
  Buffer bytes;
  append(bytes, record);
  if (bytes.size() > kMaxMetadataBytes) {
    return Error{ErrorCode::kUsage, name_ + ": metadata " + record.name + ": expected at most " +
                                        std::to_string(kMaxMetadataBytes) + " bytes, found " +
                                        std::to_string(bytes.size())};
  }
  const std::uint64_t start = size_;
  if (auto ok = put_record(bytes); !ok) return ok;
  append(metadata_indexes_, MetadataIndex{start, bytes.size(), std::move(record.name)});
  ++statistics_.metadata;
  return {};
}

/// Writes the summary, the offsets of its groups and the end of the file.
Result<void> Writer::put_summary() {
  for (std::size_t channel = 0; channel < counts_.size(); ++channel) {
    if (counts_[channel] == 0) continue;
    statistics_.channel_messages[static_cast<std::uint16_t>(channel)] = counts_[channel];
  }
  Buffer statistics;
  append(statistics, statistics_);
  const std::pair<Opcode, const Buffer*> groups[] = {
      {Opcode::kSchema, &schemas_},
      {Opcode::kChannel, &channels_},
      {Opcode::kStatistics, &statistics},
      {Opcode::kChunkIndex, &chunk_indexes_},
      {Opcode::kAttachmentIndex, &attachment_indexes_},
      {Opcode::kMetadataIndex, &metadata_indexes_}};
  const std::uint64_t start = size_;
  std::uint32_t crc = 0;
  Buffer end;
  for (const auto& [group, records] : groups) {
    if (records->empty()) continue;
    append(end, SummaryOffset{group, size_, records->size()});
    crc = crc32_of(*records, crc);
    if (auto ok = put(*records, start); !ok) return ok;
  }
  append(end, Footer{start, size_, 0});
  crc = crc32_of(std::span<const std::byte>(end).first(end.size() - 4), crc);
  ByteWriter(end).patch(end.size() - 4, crc);
  end.insert(end.end(), kMagic.begin(), kMagic.end());
  return put(end, start);
}

Result<void> Writer::finish() {
  if (auto ok = flush(); !ok) return ok;
  Buffer data_end;
  append_data_end(data_end, data_crc_);
  if (auto ok = put_record(data_end); !ok) return ok;
  if (auto ok = put_summary(); !ok) return ok;
  // A pipe cannot be synced; this is not an error.
  if (::fsync(descriptor_.get()) != 0 && errno != EINVAL && errno != EROFS) {
    stopped_ = Error{ErrorCode::kIo, name_ + ": cannot sync: " + std::strerror(errno)};
    return *stopped_;
  }
  if (const int reason = descriptor_.close(); reason != 0) {
    stopped_ = Error{ErrorCode::kIo, name_ + ": cannot close: " + std::strerror(reason)};
    return *stopped_;
  }
  return {};
}

}  // namespace nav::io::mcap
