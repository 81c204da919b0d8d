// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/mcap_reader.hpp"

#include <algorithm>
#include <utility>

#include "io/mcap/mcap_bytes.hpp"

namespace nav::io::mcap {

namespace {

/// Stores a declaration under its id. Returns true if it changes anything.
template <class Entry, class Parser>
bool declare(std::vector<std::unique_ptr<Entry>>& table, std::span<const std::byte> content,
             Parser parse, bool& malformed) {
  const std::size_t id = ByteReader(content).number<std::uint16_t>();
  if (id < table.size() && table[id] &&
      std::equal(content.begin(), content.end(), table[id]->bytes.begin(),
                 table[id]->bytes.end())) {
    return false;
  }
  auto record = parse(content);
  if (!record) {
    malformed = true;
    return false;
  }
  if (id >= table.size()) table.resize(id + 1);
  table[id] = std::make_unique<Entry>();
  table[id]->bytes.assign(content.begin(), content.end());
  table[id]->record = *std::move(record);
  return true;
}

}  // namespace

Result<Reader> Reader::open(std::shared_ptr<const Input> input, ReaderOptions options) {
  Reader reader;
  auto summary = read_summary(*input);
  if (!summary) return summary.error();
  reader.has_intact_summary_ = summary->has_value();
  if (options.use_index) reader.summary_ = *std::move(summary);
  reader.input_ = std::move(input);
  reader.options_ = std::move(options);
  reader.rewind();
  return reader;
}

void Reader::rewind() {
  walk_ = summary_ ? walk_by_index(input_, *summary_, options_.max_chunk_bytes, options_.filter)
                   : walk_by_scan(input_, options_.max_chunk_bytes);
  records_ = {};
  malformed_chunks_ = 0;
  chunk_is_malformed_ = false;
}

void Reader::take_schema(std::span<const std::byte> content) {
  definitions_ += declare(schemas_, content, parse_schema, chunk_is_malformed_) ? 1 : 0;
}

void Reader::take_channel(std::span<const std::byte> content) {
  definitions_ += declare(channels_, content, parse_channel, chunk_is_malformed_) ? 1 : 0;
}

bool Reader::take_message(std::span<const std::byte> content) {
  const auto head = parse_message_head(content);
  const bool known = head && head->channel < channels_.size() && channels_[head->channel];
  if (!known) {
    chunk_is_malformed_ = true;
    return false;
  }
  const Channel& channel = channels_[head->channel]->record;
  const bool has_schema = channel.schema < schemas_.size() && schemas_[channel.schema];
  if (!has_schema && channel.schema != 0) {
    chunk_is_malformed_ = true;
    return false;
  }
  message_ = {.head = *head,
              .channel = &channel,
              .schema = has_schema ? &schemas_[channel.schema]->record : nullptr,
              .definitions = definitions_,
              .data = content.subspan(kMessageHeadBytes)};
  return true;
}

/// Reads one record of the chunk; true: it is a message.
bool Reader::take_record() {
  ByteReader from(records_);
  const auto opcode = static_cast<Opcode>(from.number<std::uint8_t>());
  const auto content = from.bytes(from.number<std::uint64_t>());
  if (!from.ok()) {
    chunk_is_malformed_ = true;
    records_ = {};
    return false;
  }
  records_ = records_.last(from.left());
  if (opcode == Opcode::kSchema) take_schema(content);
  if (opcode == Opcode::kChannel) take_channel(content);
  return opcode == Opcode::kMessage && take_message(content);
}

Result<Event> Reader::next() {
  while (true) {
    while (!records_.empty()) {
      if (take_record()) return Event{.message = &message_};
    }
    malformed_chunks_ += std::exchange(chunk_is_malformed_, false) ? 1 : 0;
    const auto found = walk_->next();
    if (!found) return found.error();
    if (!*found) return Event{};
    const Found& record = **found;
    if (record.what == Finding::kAttachment) return Event{.attachment = &record.attachment};
    if (record.what == Finding::kMetadata) return Event{.metadata = &record.metadata};
    records_ = record.records;
  }
}

std::string Reader::damage() const {
  const Loss& lost = loss();
  std::string found;
  const auto add = [&](const std::string& part) { found += (found.empty() ? "" : ", ") + part; };
  if (!has_intact_summary_) add("no intact index at its end");
  if (lost.places > 0) {
    add(std::to_string(lost.bytes) + " damaged or incomplete bytes in " +
        std::to_string(lost.places) + (lost.places == 1 ? " place" : " places") + " from byte " +
        std::to_string(lost.first) + " on");
  }
  if (malformed_chunks_ > 0) {
    add(std::to_string(malformed_chunks_) + " chunks with records against the format");
  }
  if (walk_->gave_up()) add("too many false beginnings of records to search on");
  if (found.empty()) return "";
  return input_->name() + ": expected a finished and intact recording, found " + found +
         "; all else was read";
}

}  // namespace nav::io::mcap
