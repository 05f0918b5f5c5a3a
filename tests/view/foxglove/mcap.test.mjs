// `tactor export --mcap`, read by the reader of those who made the format.
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import { check, turnedAxis } from "./checks.mjs";

const tactor = process.env.TACTOR;
const decompressHandlers = { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) };
let folder, file, reader;

/** Times and columns of a recorded stream, as the recording holds them. */
function recorded(stream) {
  const [head, ...rows] = execFileSync(tactor, ["export", join(folder, "out/recording.h5"), stream]).toString().trim().split("\n");
  const names = head.split(",");
  return rows.map((row) => Object.fromEntries(row.split(",").map((value, i) => [names[i], Number(value)])));
}

async function messagesOf(topic, range = {}) {
  const found = [];
  for await (const message of reader.readMessages({ topics: [topic], ...range })) {
    found.push({ time: Number(message.logTime) * 1e-9, value: JSON.parse(Buffer.from(message.data).toString()) });
  }
  return found;
}

before(async () => {
  folder = mkdtempSync(join(tmpdir(), "tactor_mcap_"));
  execFileSync(tactor, ["run", process.env.GRAPH, "--duration", "3 s", "--out", join(folder, "out"),
    "--set", "record=[device.commanded,device.state]"]);
  execFileSync(tactor, ["export", join(folder, "out/recording.h5"), "--mcap", join(folder, "run.mcap")]);
  file = readFileSync(join(folder, "run.mcap"));
  const readable = {
    size: async () => BigInt(file.length),
    read: async (offset, size) => new Uint8Array(file.subarray(Number(offset), Number(offset + size))),
  };
  reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
});

after(() => rmSync(folder, { recursive: true }));

test("the index tells what the file holds", async () => {
  const counted = new Map();
  for await (const { channelId } of reader.readMessages()) counted.set(channelId, (counted.get(channelId) ?? 0n) + 1n);
  for (const [id, count] of reader.statistics.channelMessageCounts) assert.equal(counted.get(id) ?? 0n, count);
  assert.equal(reader.statistics.chunkCount, reader.chunkIndexes.length);
  assert.equal(reader.statistics.channelCount, reader.channelsById.size);
  const [about] = reader.metadataIndexes;
  assert.equal(about.name, "tactor");
});

test("it is read without the index too, and all checksums are right", () => {
  const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  stream.append(file);
  let messages = 0n;
  for (let record = stream.nextRecord(); record; record = stream.nextRecord()) if (record.type === "Message") messages += 1n;
  assert.ok(stream.done());
  assert.equal(messages, reader.statistics.messageCount);
});

test("each message is what its schema says", async () => {
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    assert.equal(channel.messageEncoding, "json");
    assert.equal(schema.encoding, "jsonschema");
    check(schema.name, Buffer.from(schema.data).toString(), JSON.parse(Buffer.from(message.data).toString()));
  }
});

test("forces and frames are those of the recording", async () => {
  const forces = recorded("device.commanded"), shown = await messagesOf("/device/commanded");
  assert.equal(shown.length, forces.length);
  assert.ok(forces.some((row) => Math.abs(row["force_z [N]"]) > 0.1));
  forces.forEach((row, i) => {
    assert.ok(Math.abs(shown[i].time - row.valid_s) < 1e-9);
    for (const axis of ["x", "y", "z"]) assert.equal(Math.fround(shown[i].value.force[axis]), Math.fround(row[`force_${axis} [N]`]));
  });
  const states = recorded("device.state");
  const handles = (await messagesOf("/tf")).filter(({ value }) => value.child_frame_id === "device/handle").slice(1);
  assert.ok(handles.length > 200);
  for (const { time, value } of handles) {
    const state = states.reduce((a, b) => (Math.abs(b.valid_s - time) < Math.abs(a.valid_s - time) ? b : a));
    for (const axis of ["x", "y", "z"]) assert.ok(Math.abs(value.translation[axis] - state[`p_WD_${axis} [m]`]) < 1e-7);
  }
});

test("the arrow of the force points along it, from the handle", async () => {
  const forces = new Map((await messagesOf("/device/commanded")).map(({ time, value }) => [time, value.force]));
  const handles = (await messagesOf("/tf")).filter(({ value }) => value.child_frame_id === "device/handle");
  let drawn = 0;
  for (const { time, value } of await messagesOf("/force")) {
    const { x, y, z } = forces.get(time), size = Math.hypot(x, y, z);
    const [entity] = value.entities;
    if (entity.arrows.length === 0) continue;
    const axis = turnedAxis(entity.arrows[0].pose.orientation);
    [x, y, z].forEach((component, i) => assert.ok(Math.abs(axis[i] - component / size) < 1e-6));
    const { position } = entity.arrows[0].pose;
    const handle = handles.filter((at) => at.time <= time + 1e-9).at(-1).value.translation;
    for (const axis of ["x", "y", "z"]) assert.equal(Math.fround(position[axis]), Math.fround(handle[axis]));
    drawn += 1;
  }
  assert.ok(drawn > 10);
});

test("a part of the time is found by the index", async () => {
  const all = await messagesOf("/device/commanded");
  const some = await messagesOf("/device/commanded", { startTime: 1_000_000_000n, endTime: 1_500_000_000n });
  assert.deepEqual(some, all.filter(({ time }) => time >= 1 && time <= 1.5));
});

test("a file that cannot be written is said", () => {
  const failed = spawnSync(tactor, ["export", join(folder, "out/recording.h5"), "--mcap", join(folder, "none/run.mcap")]);
  assert.notEqual(failed.status, 0);
  assert.match(failed.stderr.toString(), /cannot write .*none\/run\.mcap/);
});

test("a recording is not written over itself", () => {
  const recording = join(folder, "out/recording.h5"), before = readFileSync(recording);
  for (const option of ["--mcap", "--html"]) {
    const failed = spawnSync(tactor, ["export", recording, option, join(folder, "out/../out/recording.h5")]);
    assert.equal(failed.status, 2);
    assert.match(failed.stderr.toString(), /is the recording itself/);
  }
  assert.deepEqual(readFileSync(recording), before);
});
