// The graph as a diagram: nodes in layers from left to right, with rates, ages and drops.

const WIDTH = 150;
const HEIGHT = 38;
const GAP_X = 74;
const GAP_Y = 16;

/** The layer of each node: the longest way to it along edges that do not go back. @returns {number[]} */
export function layersOf(nodes, edges) {
  const index = new Map(nodes.map((n, i) => [n.name, i]));
  const out = nodes.map(() => []);
  for (const e of edges) out[index.get(e.from)].push(index.get(e.to));
  const state = nodes.map(() => 0);  // 0 new, 1 on the way, 2 done
  const forward = nodes.map(() => []);
  const order = [];
  const visit = (n) => {
    state[n] = 1;
    for (const m of out[n]) {
      if (state[m] === 1) continue;  // a feedback edge
      forward[n].push(m);
      if (state[m] === 0) visit(m);
    }
    state[n] = 2;
    order.unshift(n);
  };
  const device = nodes.findIndex((n) => n.role === 'device');
  const fed = nodes.findIndex((n) => edges.some((e) => e.from === n.name && e.to === nodes[device]?.name) && !edges.some((e) => e.to === n.name));
  for (const first of [fed, device]) if (first >= 0 && state[first] === 0) visit(first);
  nodes.forEach((_, n) => { if (state[n] === 0) visit(n); });
  const layer = nodes.map(() => 0);
  for (const n of order) for (const m of forward[n]) layer[m] = Math.max(layer[m], layer[n] + 1);
  return layer;
}

function svg(tag, attributes = {}, text) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

const hertz = (rate) => rate === null || rate === undefined ? '' : rate >= 10 ? `${Math.round(rate)} Hz` : `${rate.toFixed(1)} Hz`;
const milliseconds = (s) => s >= 10 ? 'old' : s >= 1e-3 ? `${(s * 1e3).toFixed(1)} ms` : `${Math.round(s * 1e6)} us`;

export class Diagram {
  constructor(parent, hello) {
    const {nodes, edges} = hello;
    const layer = layersOf(nodes, edges);
    const rows = [];
    this.at = nodes.map((_, i) => {
      rows[layer[i]] = (rows[layer[i]] ?? 0) + 1;
      return {x: 8 + layer[i] * (WIDTH + GAP_X), y: 8 + (rows[layer[i]] - 1) * (HEIGHT + GAP_Y)};
    });
    const width = Math.max(...this.at.map((p) => p.x)) + WIDTH + 8;
    const height = Math.max(...this.at.map((p) => p.y)) + HEIGHT + 34;
    const root = svg('svg', {width, height, viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': 'The graph of this run'});
    const index = new Map(nodes.map((n, i) => [n.name, i]));
    this.edges = edges.map((e) => {
      const a = this.at[index.get(e.from)];
      const b = this.at[index.get(e.to)];
      const back = b.x <= a.x;
      const x1 = a.x + WIDTH;
      const y1 = a.y + HEIGHT / 2;
      const [x2, y2] = [b.x, b.y + HEIGHT / 2];
      const bend = back ? 40 : Math.max(30, (x2 - x1) / 2);
      const low = back ? Math.max(y1, y2) + HEIGHT : 0;
      const d = back ? `M${x1},${y1} C${x1 + bend},${low} ${x2 - bend},${low} ${x2},${y2}` : `M${x1},${y1} C${x1 + bend},${y1} ${x2 - bend},${y2} ${x2},${y2}`;
      const path = svg('path', {d});
      const title = svg('title');
      path.append(title);
      const text = svg('text', {class: 'small', x: back ? (x1 + x2) / 2 : x1 + 4, y: back ? low - 6 : y1 + (y2 - y1) * 0.12 - 3});
      root.append(path, text);
      return {text, title, name: `${e.name} (${e.queue})`};
    });
    this.nodes = nodes.map((n, i) => {
      const {x, y} = this.at[i];
      const box = svg('rect', {class: 'box', x, y, width: WIDTH, height: HEIGHT, rx: 4});
      box.append(svg('title', {}, `${n.name}: ${n.type}, ${n.role}, in lane ${n.lane}`));
      const rate = svg('text', {class: 'small', x: x + WIDTH - 6, y: y + 31, 'text-anchor': 'end'});
      root.append(box, svg('text', {x: x + 6, y: y + 16}, n.name), svg('text', {class: 'small', x: x + 6, y: y + 31}, n.type.length > 20 ? `${n.type.slice(0, 19)}…` : n.type), rate);
      return {box, rate};
    });
    parent.append(root);
  }
  /** @param {object} status */
  update(status) {
    status.nodes.forEach((n, i) => {
      this.nodes[i].rate.textContent = hertz(n.rate);
      this.nodes[i].box.dataset.stalled = n.stalled;
    });
    const told = new Set();
    status.edges.forEach((e, i) => {
      const {text, title, name} = this.edges[i];
      const parts = [];
      if (e.rate) parts.push(hertz(e.rate));
      if (e.age !== undefined && e.rate) parts.push(milliseconds(e.age));
      if (e.dropped) parts.push(`${e.dropped} dropped`);
      title.textContent = `${name}: ${parts.join(', ') || 'no messages'}`;
      // Edges out of one port begin at one place: the first tells its rate, all tell their drops.
      const from = name.split(' -> ')[0];
      const label = told.has(from) && !e.dropped ? '' : parts.slice(e.dropped ? -1 : 1).join(' ');
      told.add(from);
      text.textContent = label;
      text.setAttribute('class', e.dropped ? 'small bad' : 'small');
    });
  }
}
