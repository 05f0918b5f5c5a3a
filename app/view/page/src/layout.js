// Places the nodes of a graph in layers from left to right and leads the edges between them.

/**
 * @param {string[]} names of the nodes
 * @param {{from: string, to: string}[]} edges
 * @param {{node_width: number, node_height: number, gap_x: number, gap_y: number}} size px
 * @returns {{width: number, height: number, nodes: Map<string, {x: number, y: number, layer: number}>,
 *   routes: {from: string, to: string, edges: number[], back: boolean, points: {x: number, y: number}[]}[]}}
 *   nodes by their upper left corners; edges between the same two nodes share a route
 */
export function layout(names, edges, size) {
  const grouped = new Map();
  edges.forEach((edge, i) => {
    if (!names.includes(edge.from) || !names.includes(edge.to) || edge.from === edge.to) return;
    const key = JSON.stringify([edge.from, edge.to]);
    if (!grouped.has(key)) grouped.set(key, { from: edge.from, to: edge.to, edges: [], back: false });
    grouped.get(key).edges.push(i);
  });
  const routes = [...grouped.values()];

  // An edge that closes a loop goes back; depth first from the nodes that nothing leads to.
  const out = new Map(names.map((name) => [name, routes.filter((route) => route.from === name)]));
  const incoming = new Set(routes.map((route) => route.to));
  const state = new Map();
  const visit = (name) => {
    state.set(name, 'open');
    for (const route of out.get(name)) {
      if (state.get(route.to) === 'open') route.back = true;
      else if (!state.has(route.to)) visit(route.to);
    }
    state.set(name, 'done');
  };
  for (const name of [...names.filter((n) => !incoming.has(n)), ...names]) if (!state.has(name)) visit(name);

  // Longest path.
  const layer = new Map(names.map((name) => [name, 0]));
  for (let round = 0, changed = true; changed && round <= names.length; ++round) {
    changed = false;
    for (const route of routes) {
      if (route.back || layer.get(route.to) > layer.get(route.from)) continue;
      layer.set(route.to, layer.get(route.from) + 1);
      changed = true;
    }
  }
  // A node without predecessors moves next to the first one that it feeds.
  for (const name of names) {
    const feeds = out.get(name).filter((route) => !route.back);
    if (!incoming.has(name) && feeds.length) layer.set(name, Math.min(...feeds.map((route) => layer.get(route.to))) - 1);
  }

  // Slots: nodes, and a bend of a route in each layer that it crosses.
  const count = Math.max(0, ...layer.values()) + 1;
  const layers = Array.from({ length: count }, () => []);
  const slot_of = new Map();
  for (const name of names) {
    const slot = { name, neighbours: [], place: 0, y: 0, height: size.node_height };
    slot_of.set(name, slot);
    layers[layer.get(name)].push(slot);
  }
  for (const route of routes) {
    let [a, b] = [layer.get(route.from), layer.get(route.to)];
    if (a > b) [a, b] = [b, a];
    route.bends = [];
    for (let l = a + 1; l < b; ++l) {
      const slot = { name: null, neighbours: [], place: 0, y: 0, height: size.node_height * 0.6, layer: l };
      route.bends.push(slot);
      layers[l].push(slot);
    }
    const way = [slot_of.get(layer.get(route.from) <= layer.get(route.to) ? route.from : route.to), ...route.bends,
      slot_of.get(layer.get(route.from) <= layer.get(route.to) ? route.to : route.from)];
    for (let i = 1; i < way.length; ++i) {
      way[i].neighbours.push(way[i - 1]);
      way[i - 1].neighbours.push(way[i]);
    }
  }
  const stack = (slots) => {
    let y = 0;
    slots.forEach((slot, i) => {
      slot.place = i;
      slot.y = y + slot.height / 2;
      y += slot.height + size.gap_y;
    });
    const middle = (y - size.gap_y) / 2;
    for (const slot of slots) slot.y -= middle;
  };
  layers.forEach(stack);
  for (let round = 0; round < 12; ++round) {
    const order = round % 2 ? [...layers].reverse() : layers;
    for (const slots of order) {
      for (const slot of slots) {
        const n = slot.neighbours.length;
        slot.wish = n ? slot.neighbours.reduce((sum, other) => sum + other.y, 0) / n : slot.y;
      }
      slots.sort((a, b) => a.wish - b.wish || a.place - b.place);
      stack(slots);
    }
  }
  // Move slots to where they wish to be, as far as their order and the gaps allow.
  for (let round = 0; round < 8; ++round) {
    for (const slots of layers) {
      for (let i = 0; i < slots.length; ++i) {
        const slot = slots[i];
        const n = slot.neighbours.length;
        if (!n) continue;
        let y = slot.neighbours.reduce((sum, other) => sum + other.y, 0) / n;
        const above = slots[i - 1];
        const below = slots[i + 1];
        if (above) y = Math.max(y, above.y + (above.height + slot.height) / 2 + size.gap_y);
        if (below) y = Math.min(y, below.y - (below.height + slot.height) / 2 - size.gap_y);
        if (!above || y >= above.y + (above.height + slot.height) / 2 + size.gap_y - 1e-6) slot.y = y;
      }
    }
  }

  const top = Math.min(0, ...layers.flat().map((slot) => slot.y - slot.height / 2));
  const bottom = Math.max(0, ...layers.flat().map((slot) => slot.y + slot.height / 2));
  const x_of = (l) => l * (size.node_width + size.gap_x);
  const nodes = new Map(names.map((name) => [name, {
    x: x_of(layer.get(name)), y: slot_of.get(name).y - size.node_height / 2 - top, layer: layer.get(name)}]));
  for (const route of routes) {
    const from = nodes.get(route.from);
    const to = nodes.get(route.to);
    const middle = size.node_height / 2;
    const forward = layer.get(route.from) < layer.get(route.to);
    const bends = route.bends.flatMap((slot) => {
      const x = x_of(slot.layer);
      return [{ x, y: slot.y - top }, { x: x + size.node_width, y: slot.y - top }];
    });
    // An edge that goes back leaves at the left side and comes in at the right side.
    // The ends of bends are in the order of the layers; an edge that goes back runs through them from the right.
    route.points = forward
      ? [{ x: from.x + size.node_width, y: from.y + middle }, ...bends, { x: to.x, y: to.y + middle }]
      : [{ x: from.x, y: from.y + middle }, ...bends.reverse(), { x: to.x + size.node_width, y: to.y + middle }];
    delete route.bends;
  }
  // Edges meet a side of a node at places of their own, in the order in which they come from above.
  for (const name of names) {
    const node = nodes.get(name);
    for (const x of [node.x, node.x + size.node_width]) {
      const ends = [];
      for (const { from, to, points } of routes) {
        if (from === name && points[0].x === x) ends.push([points[0], points[1]]);
        if (to === name && points.at(-1).x === x) ends.push([points.at(-1), points.at(-2)]);
      }
      ends.sort((a, b) => a[1].y - b[1].y);
      const gap = Math.min(11, (size.node_height - 8) / Math.max(1, ends.length - 1));
      ends.forEach(([end], i) => (end.y += (i - (ends.length - 1) / 2) * gap));
    }
  }
  return { width: x_of(count - 1) + size.node_width, height: bottom - top, nodes, routes };
}
