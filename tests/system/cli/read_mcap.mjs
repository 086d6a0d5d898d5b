// node read_mcap.mjs FILE...: reads traces with the public MCAP reader, checksums included, and
// decodes the first message of each by the schema in the file. One line of JSON for each file.
import fs from 'node:fs';
import { createRequire } from 'node:module';

// Modules come from NODE_PATH, which only CommonJS obeys.
const require = createRequire(import.meta.url);
const { McapIndexedReader, McapStreamReader } = require('@mcap/core');
const fzstd = require('fzstd');
const flatbuffers = require('flatbuffers');
const { Parser, Schema, Table } = require('flatbuffers_reflection');

const decompressHandlers = {
  zstd: (bytes, size) => fzstd.decompress(bytes, new Uint8Array(Number(size))),
};

function decoded(reader, message) {
  const { schemaId } = reader.channelsById.get(message.channelId);
  const schema = new flatbuffers.ByteBuffer(reader.schemasById.get(schemaId).data);
  const table = Table.getRootTable(new flatbuffers.ByteBuffer(message.data));
  return new Parser(Schema.getRootAsSchema(schema)).toObject(table);
}

for (const path of process.argv.slice(2)) {
  const bytes = new Uint8Array(fs.readFileSync(path));
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => bytes.slice(Number(offset), Number(offset + size)),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const report = { indexed: 0, streamed: 0, topics: [], metadata: {} };
  for await (const message of reader.readMessages()) {
    if (report.indexed++ === 0) {
      const entry = decoded(reader, message);
      report.first = { topic: reader.channelsById.get(message.channelId).topic,
                       wall_ns_is_log_time: BigInt(entry.wall_ns) === message.logTime,
                       body_bytes: entry.message.length };
    }
  }
  for await (const metadata of reader.readMetadata()) {
    report.metadata[metadata.name] = Object.fromEntries(metadata.metadata);
  }
  report.topics = [...reader.channelsById.values()].map((channel) => channel.topic).sort();
  report.counted = Number(reader.statistics.messageCount);
  const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  stream.append(bytes);
  for (let record; (record = stream.nextRecord());) {
    report.streamed += record.type === 'Message' ? 1 : 0;
  }
  report.done = stream.done();
  console.log(JSON.stringify(report));
}
