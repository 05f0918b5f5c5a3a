// `tactor view --foxglove`, read by the client of those who made the protocol.
import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { once } from "node:events";
import { createInterface } from "node:readline";
import { after, before, test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";
import { check } from "./checks.mjs";

const { FoxgloveClient } = protocol;
const tactor = process.env.TACTOR;
let view, page, url;

/** A viewer: what it was told lies in its members. */
class Viewer {
  channels = [];
  messages = [];
  statuses = [];
  parameters = [];
  times = [];
  static async open(spoken = FoxgloveClient.SUPPORTED_SUBPROTOCOL) {
    const viewer = new Viewer();
    viewer.socket = new WebSocket(url, [spoken]);
    viewer.client = new FoxgloveClient({ ws: viewer.socket });
    viewer.client.on("serverInfo", (info) => (viewer.info = info));
    viewer.client.on("advertise", (channels) => viewer.channels.push(...channels));
    viewer.client.on("message", (message) => viewer.messages.push(message));
    viewer.client.on("status", (status) => viewer.statuses.push(status));
    viewer.client.on("parameterValues", (values) => viewer.parameters.push(values));
    viewer.client.on("time", ({ timestamp }) => viewer.times.push(timestamp));
    await viewer.wait(() => viewer.channels.length > 0);
    return viewer;
  }
  async wait(test) {
    for (let i = 0; i < 1000; ++i) {
      if (test()) return;
      await sleep(10);
    }
    assert.fail("what was waited for did not come");
  }
  channel(topic) {
    const found = this.channels.find((channel) => channel.topic === topic);
    assert.ok(found, `no ${topic} among ${this.channels.map((channel) => channel.topic)}`);
    return found;
  }
  subscribe(topic) {
    const channel = this.channel(topic), id = this.client.subscribe(channel.id);
    return {
      id,
      channel,
      got: () => this.messages.filter((m) => m.subscriptionId === id)
        .map((m) => ({ time: m.timestamp, value: JSON.parse(Buffer.from(m.data.buffer, m.data.byteOffset, m.data.byteLength).toString()) })),
    };
  }
  close() {
    this.socket.terminate();
  }
}

before(async () => {
  view = spawn(tactor, ["view", process.env.GRAPH, "--no-open", "--no-reference", "--foxglove=0"], { stdio: ["ignore", "pipe", "inherit"] });
  for await (const line of createInterface({ input: view.stdout })) {
    page ??= line.match(/http:\/\/127\.0\.0\.1:(\d+)\/#(\w+)/);
    url ??= line.match(/ws:\/\/127\.0\.0\.1:\d+/)?.[0];
    if (page && url) break;
  }
});

after(() => view.kill("SIGKILL"));

test("it tells its channels, by both names of the protocol", async () => {
  for (const spoken of ["foxglove.websocket.v1", "foxglove.sdk.v1"]) {
    const viewer = await Viewer.open(spoken);
    assert.equal(viewer.socket.protocol, spoken);
    assert.deepEqual([...viewer.info.capabilities].sort(), ["parameters", "parametersSubscribe", "time"]);
    for (const topic of ["/scene", "/tf", "/force", "/device/commanded"]) viewer.channel(topic);
    viewer.close();
  }
});

test("whoever comes gets the scene, the frames and the forces, as the schemas say", async () => {
  const viewer = await Viewer.open();
  const scene = viewer.subscribe("/scene"), frames = viewer.subscribe("/tf"), force = viewer.subscribe("/device/commanded");
  await viewer.wait(() => scene.got().length > 0 && frames.got().length > 20 && force.got().length > 200);
  for (const { channel, got } of [scene, frames, force]) {
    assert.equal(channel.encoding, "json");
    for (const { value } of got()) check(channel.schemaName, channel.schema, value);
  }
  const bodies = scene.got()[0].value.entities.map((entity) => entity.id);
  assert.ok(bodies.includes("device/handle") && bodies.length > 2);
  const named = new Set(frames.got().map(({ value }) => value.child_frame_id));
  assert.deepEqual([...named].sort(), ["device/handle", "tool"]);
  const times = force.got().map(({ time }) => time);
  // A tick is a millisecond; one that was missed leaves a gap.
  for (let i = 1; i < times.length; ++i) assert.ok(times[i] > times[i - 1] && times[i] - times[i - 1] < 100_000_000n);
  // Time is told before each message that is of a later one, and never goes back.
  assert.ok(viewer.times.length > 100 && viewer.times.at(-1) >= times.at(-1) - 200_000_000n);
  for (let i = 1; i < viewer.times.length; ++i) assert.ok(viewer.times[i] > viewer.times[i - 1]);
  viewer.client.unsubscribe(force.id);
  await sleep(300);
  const before = force.got().length;
  await sleep(300);
  assert.equal(force.got().length, before);
  viewer.close();
});

test("parameters are told and followed, and cannot be changed", async () => {
  const viewer = await Viewer.open();
  viewer.client.getParameters([], "all");
  await viewer.wait(() => viewer.parameters.length === 1);
  assert.equal(viewer.parameters[0].id, "all");
  const k = viewer.parameters[0].parameters.find(({ name }) => name === "coupling.k_0");
  assert.ok(k && k.value > 0, JSON.stringify(viewer.parameters[0]));
  viewer.client.setParameters([{ name: "coupling.k_0", value: 1 }], "set");
  await viewer.wait(() => viewer.parameters.length === 2 && viewer.statuses.length === 1);
  assert.match(viewer.statuses[0].message, /read-only/);
  assert.deepEqual(viewer.parameters[1].parameters.find(({ name }) => name === "coupling.k_0"), k);

  viewer.client.subscribeParameterUpdates(["coupling.k_0"]);
  const control = new WebSocket(`ws://127.0.0.1:${page[1]}/stream`, ["tactor.view", `token.${page[2]}`], { origin: `http://127.0.0.1:${page[1]}` });
  await once(control, "open");
  const value = k.value / 2;
  control.send(JSON.stringify({ type: "set", parameter: "coupling.k_0", value: String(value) }));
  await viewer.wait(() => viewer.parameters.length === 3);
  assert.deepEqual(viewer.parameters[2].parameters, [{ name: "coupling.k_0", value }]);
  control.terminate();
  const later = await Viewer.open();
  later.client.getParameters(["coupling.k_0"], "one");
  await later.wait(() => later.parameters.length === 1);
  assert.deepEqual(later.parameters[0].parameters, [{ name: "coupling.k_0", value }]);
  viewer.close();
  later.close();
});

test("what is no request is said, and the connection stays", async () => {
  const viewer = await Viewer.open();
  for (const text of ["", "{", "[]", '{"op":1}', '{"op":"subscribe"}', '{"op":"subscribe","subscriptions":[{"id":-1,"channelId":0}]}',
    '{"op":"unsubscribe","subscriptionIds":[1e300]}', '{"op":"getParameters","parameterNames":[1]}', "[".repeat(10000)]) {
    viewer.socket.send(text);
  }
  await viewer.wait(() => viewer.statuses.length === 9);
  viewer.socket.send(JSON.stringify({ op: "subscribe", subscriptions: [{ id: 1, channelId: 4096 }] }));
  await viewer.wait(() => viewer.statuses.length === 10);
  assert.match(viewer.statuses[9].message, /no channel 4096/);
  viewer.socket.send(Buffer.from([1, 2, 3]));
  const scene = viewer.subscribe("/scene");
  await viewer.wait(() => scene.got().length > 0);
  viewer.close();
});

test("who speaks another protocol, sends too much or comes as the ninth is not let in", async () => {
  await assert.rejects(once(new WebSocket(url, ["tactor.view"]), "open"));
  await assert.rejects(once(new WebSocket(url), "open"));
  const loud = await Viewer.open();
  loud.socket.send("x".repeat(65 * 1024));
  await once(loud.socket, "close");
  const viewers = [];
  for (let i = 0; i < 8; ++i) viewers.push(await Viewer.open());
  await assert.rejects(once(new WebSocket(url, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]), "open"));
  for (const viewer of viewers) viewer.close();
});

test("one that does not read loses samples, is told, and costs the others nothing", async () => {
  const slow = await Viewer.open();
  for (const { topic } of slow.channels) slow.subscribe(topic);
  slow.socket.pause();
  const viewer = await Viewer.open(), force = viewer.subscribe("/device/commanded");
  await sleep(12_000);
  const times = force.got().map(({ time }) => time);
  assert.ok(times.length > 10_000, `${times.length} messages`);
  slow.socket.resume();
  await slow.wait(() => slow.statuses.some(({ message }) => /messages were left out/.test(message)));
  assert.ok(!viewer.statuses.length);
  slow.close();
  viewer.close();
});

test("a port that is taken, or is none, is bad input", () => {
  for (const [port, message] of [[url.match(/\d+$/)[0], /--foxglove=PORT/], ["70000", /70000 not in range/], ["x", /x not in range/]]) {
    const failed = spawnSync(tactor, ["view", process.env.GRAPH, "--no-open", `--foxglove=${port}`]);
    assert.equal(failed.status, 2);
    assert.match(failed.stderr.toString(), message);
  }
});

test("whoever looks on at the end is told of it", async () => {
  const viewer = await Viewer.open();
  for (const { topic } of viewer.channels) viewer.subscribe(topic);
  await viewer.wait(() => viewer.messages.length > 1000);
  const exit = once(view, "exit"), closed = once(viewer.socket, "close");
  view.kill("SIGINT");
  const [code] = await exit;
  assert.equal(code, 0);
  await closed;
  assert.match(viewer.statuses.at(-1).message, /the run has ended/);
});
