// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Reads a recording with the reader of the MCAP project, @mcap/core of npm, which checks the
// checksums of chunks and attachments, and prints its counts and times as one line of JSON.
//
//     node mcap_foreign_reader.mjs FOLDER FILE
//
// FOLDER contains node_modules. Exit code 3: the package is not there.
import { openSync, readSync, fstatSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";
import zlib from "node:zlib";

const [folder, path] = process.argv.slice(2);
let mcap;
try {
  mcap = createRequire(resolve(folder, "here.js"))("@mcap/core");
} catch (error) {
  console.error(error.message);
  process.exit(3);
}

const file = openSync(path, "r");
const readable = {
  size: async () => BigInt(fstatSync(file).size),
  read: async (offset, size) => {
    const buffer = new Uint8Array(Number(size));
    readSync(file, buffer, 0, buffer.length, Number(offset));
    return buffer;
  },
};

const indexed = await mcap.McapIndexedReader.Initialize({ readable });
const counts = {};
let first, last, publish = 0n, sequence = 0;
for await (const message of indexed.readMessages({ validateCrcs: true })) {
  const topic = indexed.channelsById.get(message.channelId).topic;
  counts[topic] = (counts[topic] ?? 0) + 1;
  first ??= message.logTime;
  last = message.logTime;
  publish += message.publishTime;
  sequence += message.sequence;
}
const attachments = [];
for await (const attachment of indexed.readAttachments({ validateCrcs: true })) {
  attachments.push(`${attachment.name} ${attachment.mediaType} ${attachment.data.length}`);
}
const metadata = [];
for await (const record of indexed.readMetadata()) metadata.push(record.name);

// The same as a stream, which meets every record of the file.
const bytes = readFileSync(path);
const stream = new mcap.McapStreamReader({ validateCrcs: true });
stream.append(bytes);
let streamed = 0;
for (let record; (record = stream.nextRecord()); ) streamed += record.type === "Message" ? 1 : 0;

const dataEnd = Number(indexed.dataEndOffset);
const dataCrc = zlib.crc32?.(bytes.subarray(0, dataEnd)) ?? indexed.dataSectionCrc;
console.log(JSON.stringify({
  attachments,
  counts,
  data_crc_holds: indexed.dataSectionCrc === dataCrc,
  first: String(first),
  last: String(last),
  metadata,
  publish: String(publish),
  sequence,
  statistics: String(indexed.statistics.messageCount),
  stream_done: stream.done(),
  streamed,
}));
