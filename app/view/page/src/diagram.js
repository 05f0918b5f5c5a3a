// The graph as a drawing, with rates on its nodes and rate, age and drops on its edges.
import { hertz, make_svg, set_text, span } from './dom.js';
import { layout } from './layout.js';

const SIZE = { node_width: 122, node_height: 46, gap_x: 98, gap_y: 18 };
const LABEL = { half_width: 42, half_height: 6 };
const MARGIN = 12;

export class Diagram {
  /** @param {HTMLElement} parent @param {{nodes: object[], edges: object[]}} hello */
  constructor(parent, hello) {
    const { nodes, edges } = hello;
    const plan = layout(nodes.map((node) => node.name), edges, SIZE);
    const width = plan.width + 2 * MARGIN;
    const height = plan.height + 2 * MARGIN;
    const root = make_svg('svg', { viewBox: `0 0 ${width} ${height}`, width, height, role: 'img', 'aria-label': 'the graph' });
    root.append(make_svg('defs', {}, [make_svg('marker', { id: 'tip', viewBox: '0 0 8 8', refX: 7.5, refY: 4, markerWidth: 7, markerHeight: 7, orient: 'auto' },
      [make_svg('path', { d: 'M0,0.8 L8,4 L0,7.2 z', class: 'tip' })])]));
    const lines = make_svg('g');
    const boxes = make_svg('g');
    const labels = make_svg('g');
    root.append(lines, boxes, labels);
    this.edges = edges;
    const taken = [];
    for (const { x, y } of plan.nodes.values()) taken.push({ x: x + SIZE.node_width / 2, y: y + SIZE.node_height / 2, half_width: SIZE.node_width / 2, half_height: SIZE.node_height / 2 });
    this.routes = plan.routes.map((route) => {
      const line = make_svg('path', { d: curve(route.points), class: 'edge', 'marker-end': 'url(#tip)' });
      const title = make_svg('title', { text: route.edges.map((i) => edges[i].name).join('\n') });
      line.append(title);
      lines.append(line);
      const at = free_place(route.points, taken);
      taken.push(at);
      const text = make_svg('text', { x: MARGIN + at.x, y: MARGIN + at.y - 3, class: 'edge-label', 'text-anchor': 'middle' });
      const rate = make_svg('tspan', { x: MARGIN + at.x });
      const drops = make_svg('tspan', { x: MARGIN + at.x, dy: 12, class: 'drops' });
      text.append(rate, drops);
      labels.append(text);
      return { route, line, title, rate, drops };
    });
    this.nodes = nodes.map((node) => {
      const { x, y } = plan.nodes.get(node.name);
      const rate = make_svg('text', { x: SIZE.node_width - 7, y: 39, class: 'node-rate', 'text-anchor': 'end' });
      const group = make_svg('g', { class: `node lane-${node.lane}`, transform: `translate(${MARGIN + x} ${MARGIN + y})` }, [
        make_svg('title', { text: `${node.name}: ${node.type}${node.lane ? `\nlane ${node.lane}` : ''}` }),
        make_svg('rect', { width: SIZE.node_width, height: SIZE.node_height, rx: 4 }),
        make_svg('text', { x: 7, y: 15, class: 'node-name', text: clip(node.name, 17) }),
        make_svg('text', { x: 7, y: 27, class: 'node-type', text: clip(node.type ?? '', 22) }),
        rate,
      ]);
      boxes.append(group);
      return { group, rate };
    });
    parent.append(root);
  }

  /** @param {{nodes?: object[], edges?: object[]}} status */
  update(status) {
    status.nodes?.forEach((told, i) => {
      const node = this.nodes[i];
      if (!node) return;
      set_text(node.rate, `${hertz(told.rate)}${told.missed ? `, ${told.missed} missed` : ''}`);
      node.group.classList.toggle('stalled', Boolean(told.stalled));
      node.group.classList.toggle('missed', Boolean(told.missed));
    });
    if (!status.edges) return;
    for (const { route, line, title, rate, drops } of this.routes) {
      const told = route.edges.map((i) => status.edges[i]).filter(Boolean);
      if (!told.length) continue;
      const fastest = told.reduce((a, b) => ((b.rate ?? 0) > (a.rate ?? 0) ? b : a));
      const dropped = told.reduce((sum, one) => sum + (one.dropped ?? 0), 0);
      set_text(rate, [hertz(fastest.rate), fastest.age === undefined ? '' : span(fastest.age)].filter(Boolean).join(', '));
      set_text(drops, dropped ? `${dropped} dropped` : '');
      line.classList.toggle('dropping', dropped > 0);
      set_text(title, route.edges.map((i) => `${this.edges[i].name}\n  ${this.edges[i].queue ?? ''}, ${hertz(status.edges[i]?.rate)}, age ${span(status.edges[i]?.age)}, `
        + `${status.edges[i]?.dropped ?? 0} dropped`).join('\n'));
    }
  }
}

const clip = (text, most) => (text.length > most ? `${text.slice(0, most - 1)}…` : text);

/** A place on a route for its label that is not taken by a node or another label, if there is one. */
function free_place(points, taken) {
  const places = [];
  for (let i = 1; i < points.length; ++i)
    for (const t of [0.5, 0.4, 0.6, 0.3, 0.7]) places.push({ ...bezier(points[i - 1], points[i], t), ...LABEL, score: Math.abs(t - 0.5) - (points[i].y === points[i - 1].y ? 0.05 : 0) });
  places.sort((a, b) => a.score - b.score);
  const overlap = (place) => taken.reduce((sum, other) => sum
    + Math.max(0, place.half_width + other.half_width - Math.abs(place.x - other.x)) * Math.max(0, place.half_height + other.half_height - Math.abs(place.y - 4 - other.y)), 0);
  return places.find((place) => overlap(place) === 0) ?? places.reduce((a, b) => (overlap(b) < overlap(a) ? b : a));
}

/** How far the handles of the curve between two points reach. */
const control = (a, b) => (b.x > a.x ? Math.max(24, 0.5 * (b.x - a.x)) : -Math.max(30, 0.5 * (a.x - b.x)));

function bezier(a, b, t) {
  const k = control(a, b);
  const mix = (p0, p1, p2, p3) => (1 - t) ** 3 * p0 + 3 * (1 - t) ** 2 * t * p1 + 3 * (1 - t) * t * t * p2 + t ** 3 * p3;
  return { x: mix(a.x, a.x + k, b.x - k, b.x), y: mix(a.y, a.y, b.y, b.y) };
}

function curve(points) {
  const f = (v) => (v + MARGIN).toFixed(1);
  let d = `M${f(points[0].x)},${f(points[0].y)}`;
  for (let i = 1; i < points.length; ++i) {
    const [a, b] = [points[i - 1], points[i]];
    const k = control(a, b);
    d += ` C${f(a.x + k)},${f(a.y)} ${f(b.x - k)},${f(b.y)} ${f(b.x)},${f(b.y)}`;
  }
  return d;
}
