// Draws the charts anew at the window's width, with curves that can be hidden and zoomed. Where no script runs, gnuplot's picture
// stays. figure_files.js stands before it.
const SHAPES = ['M-4,0a4,4 0 1 0 8,0a4,4 0 1 0 -8,0z', 'M-3.6,-3.6h7.2v7.2h-7.2z', 'M0,-5l4.6,8h-9.2z', 'M0,-5l5,5l-5,5l-5,-5z',
  'M0,5l4.6,-8h-9.2z', 'M0,-5l5,4l-2,5h-6l-2,-5z', 'M-5,0h10M0,-5v10', 'M-5,0h10M0,-5v10M-3,-3l6,6M3,-3l-6,6'];
const DASHES = ['none', '5 4', '2 3', '8 3 2 3'];
const LEFT = 58, RIGHT = 12, TOP = 8, BOTTOM = 38;

function add(parent, name, attributes, text = '') {
  const child = document.createElementNS(name === 'svg' ? 'http://www.w3.org/2000/svg' : parent.namespaceURI, name);
  for (const key in attributes) child.setAttribute(key, attributes[key]);
  child.textContent = text;
  return parent.appendChild(child);
}

// Greys are the page's own, so that they can be seen on a dark one.
const color = ({color: c}) => '--color:' + (c === '#000000' ? 'var(--ink)' : /^#(..)\1\1$/.test(c) ? 'var(--soft)' : c);

// Gives each curve its points: lists of [x, y], of logarithms where the axis is logarithmic.
function read(chart, lists) {
  const scale = k => v => chart.log[k] ? v > 0 ? Math.log10(v) : NaN : v ?? NaN, [X, Y] = [scale(0), scale(1)];
  const known = points => points.filter(p => isFinite(p[0]) && isFinite(p[1]));
  for (const curve of chart.curves) {
    curve.x = lists[curve.x];
    const bars = curve.x_low, points = known(curve.x.map((x, i) => [X(x), Y(curve.y[i])]));
    curve.has_marks = curve.points || curve.joined || bars;
    curve.mark ??= 0;
    const steps = points.flatMap((p, i) => i && curve.steps ? [[p[0], points[i - 1][1]], p] : [p]);
    curve.lines = curve.points || bars ? [] : [steps];
    if (bars) curve.x.forEach((x, i) => curve.lines.push(known([[X(bars[i]), Y(curve.y[i])], [X(curve.x_high[i]), Y(curve.y[i])]]),
      known([[X(x), Y(curve.y_low[i])], [X(x), Y(curve.y_high[i])]])));
    curve.marks = curve.has_marks ? points.map(p => [p]) : [];
    curve.parts = curve.lines.concat(curve.marks).filter(part => part.length);
  }
  const all = chart.curves.flatMap(curve => curve.parts.flat()).map(p => p[0]);
  const low = all.reduce((a, b) => Math.min(a, b), Infinity), high = all.reduce((a, b) => Math.max(a, b), -Infinity);
  const margin = 0.03 * (high - low) || 0.1, [from, to] = (chart.range || []).map(X);
  chart.x_all = from < to ? [from, to] : [low - margin, high + margin];
}

// Where an axis has ticks: [place, text].
function ticks([low, high], most, log) {
  const list = [], put = v => list.push([log ? Math.log10(v) : v, String(+v.toPrecision(9))]);
  if (log && high - low > 1) {
    for (let e = Math.floor(low); e <= high; ++e) (high - low < 3 ? [1, 2, 5] : [1]).forEach(step => put(step * 10 ** e));
    return list.filter(([at]) => at >= low && at <= high);
  }
  const [from, to] = log ? [10 ** low, 10 ** high] : [low, high];
  const wish = (to - from) / most, decade = 10 ** Math.floor(Math.log10(wish));
  const step = decade * [1, 2, 5, 10].find(s => s * decade >= wish);
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + 1e-9 * step; ++k) put(k * step);
  return list;
}

// What of the points is in the range of x, with one more at each end of a line.
const within = (points, [low, high]) => points.filter((p, i) => {
  const x = [points[i - 1] || p, p, points[i + 1] || p].map(q => q[0]);
  return Math.max(...x) >= low && Math.min(...x) <= high;
});

const shown = chart => chart.curves.filter(curve => !curve.hidden);

// The range of y that shows all visible curves.
function fitted(chart, range) {
  let low = Infinity, high = -Infinity;
  for (const part of shown(chart).flatMap(curve => curve.parts)) {
    for (const [, y] of within(part, range)) [low, high] = [Math.min(low, y), Math.max(high, y)];
  }
  if (low > high) return [0, 1];
  const margin = 0.05 * (high - low) || 0.05 * Math.abs(high) || 1;
  return [low - margin, high + margin];
}

function add_mark(parent, curve, at) {
  add(parent, 'path', {class: curve.hollow ? 'mark hollow' : 'mark', style: color(curve), d: SHAPES[curve.mark % 8], transform: `translate(${at})`});
}

function add_line(parent, curve, d) {
  add(parent, 'path', {class: 'line', style: color(curve), d, 'stroke-dasharray': DASHES[curve.dash % 4 || 0]});
}

// The sample before a curve's name.
function add_sample(parent, curve, x, y) {
  if (curve.lines.length && !curve.x_low) add_line(parent, curve, `M${x},${y}h22`);
  if (curve.has_marks) add_mark(parent, curve, `${x + 11},${y}`);
}

function draw(chart) {
  const {svg, height} = chart, range = chart.view.x || chart.x_all, y = fitted(chart, range);
  const width = Math.max(svg.parentNode.clientWidth, 240), w = width - LEFT - RIGHT, h = height - TOP - BOTTOM;
  const X = v => (LEFT + (v - range[0]) / (range[1] - range[0]) * w).toFixed(1);
  const Y = v => (TOP + (y[1] - v) / (y[1] - y[0]) * h).toFixed(1);
  chart.at = px => range[0] + (Math.min(Math.max(px, LEFT), LEFT + w) - LEFT) / w * (range[1] - range[0]);
  chart.back.hidden = !chart.view.x;
  svg.replaceChildren();
  svg.setAttribute('width', width);
  svg.setAttribute('height', height);
  for (const [v, text] of ticks(range, Math.max(2, w / 90), chart.log[0])) {
    add(svg, 'path', {class: 'grid', d: `M${X(v)},${TOP}v${h}`});
    add(svg, 'text', {x: X(v), y: TOP + h + 15, 'text-anchor': 'middle'}, text);
  }
  for (const [v, text] of ticks(y, Math.max(2, h / 35), chart.log[1])) {
    add(svg, 'path', {class: 'grid', d: `M${LEFT},${Y(v)}h${w}`});
    add(svg, 'text', {x: LEFT - 6, y: +Y(v) + 4, 'text-anchor': 'end'}, text);
  }
  add(svg, 'text', {x: LEFT + w / 2, y: height - 5, 'text-anchor': 'middle'}, chart.x);
  add(svg, 'text', {transform: `translate(11,${TOP + h / 2})rotate(-90)`, 'text-anchor': 'middle'}, chart.y);
  // The inner picture cuts off what is outside of the frame.
  const plot = add(svg, 'svg', {x: LEFT, y: TOP, width: w, height: h, viewBox: `${LEFT} ${TOP} ${w} ${h}`});
  for (const curve of shown(chart)) {
    const placed = parts => parts.map(part => within(part, range).map(p => X(p[0]) + ',' + Y(p[1]))).filter(part => part.length);
    const d = placed(curve.lines).map(part => 'M' + part.join('L')).join('');
    if (d) add_line(plot, curve, d);
    for (const [at] of placed(curve.marks)) add_mark(plot, curve, at);
  }
  add(svg, 'rect', {class: 'frame', x: LEFT, y: TOP, width: w, height: h});
}

// Shows a range in all charts that share it; null: the whole.
function zoom(chart, range) {
  const [low, high] = chart.x_all;
  if (range) {
    const length = Math.max(range[1] - range[0], 1e-4 * (high - low));
    const from = Math.max(low, Math.min(range[0], high - length));
    range = length < high - low ? [from, from + length] : null;
  }
  chart.view.x = range;
  chart.view.charts.forEach(draw);
}

function listen(chart) {
  const {svg} = chart, place = event => event.clientX - svg.getBoundingClientRect().left;
  let from = null, box;
  svg.onpointerdown = event => {
    if (event.button) return;
    from = place(event);
    box = add(svg, 'rect', {class: 'dragged', y: TOP, height: chart.height - TOP - BOTTOM});
    svg.setPointerCapture(event.pointerId);
  };
  svg.onpointermove = event => {
    if (from === null) return;
    box.setAttribute('x', Math.min(from, place(event)));
    box.setAttribute('width', Math.abs(from - place(event)));
  };
  svg.onpointerup = svg.onpointercancel = event => {
    if (from === null) return;
    const ends = [from, place(event)].sort((a, b) => a - b);
    from = null;
    box.remove();
    if (event.type === 'pointerup' && ends[1] - ends[0] > 5) zoom(chart, ends.map(chart.at));
  };
  svg.ondblclick = () => zoom(chart, null);
  svg.onkeydown = event => {
    const [low, high] = chart.view.x || chart.x_all, part = (high - low) / 4;
    const by = {'+': [part, -part], '-': [-2 * part, 2 * part], ArrowLeft: [-part, -part], ArrowRight: [part, part], 0: null}[event.key];
    if (by === undefined || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    zoom(chart, by && [low + by[0], high + by[1]]);
  };
}

function build(figure, chart) {
  const box = add(figure, 'div', {class: 'chart'});
  add(box, 'b', {}, chart.title);
  chart.svg = add(box, 'svg', {tabindex: 0, role: 'img', 'aria-label': chart.title});
  const key = add(box, 'div', {class: 'key'});
  for (const curve of chart.curves.filter(curve => curve.name && curve.parts.length)) {
    const button = add(key, 'button', {'aria-pressed': true});
    add(button, 'i', {style: color(curve), class: curve.has_marks ? 'mark' : curve.dash ? 'line dashed' : 'line'},
      curve.has_marks ? (curve.hollow ? '○□△◇▽⬠✚✱' : '●■▲◆▼⬟✚✱')[curve.mark % 8] : '');
    button.append(curve.name);
    button.onclick = () => {
      button.setAttribute('aria-pressed', !!curve.hidden);
      curve.hidden = !curve.hidden;
      draw(chart);
    };
  }
  chart.back = add(key, 'button', {}, 'show the whole range');
  chart.back.onclick = () => zoom(chart, null);
  add_buttons(key, chart.name, () => picture_of(chart), () => table([{...chart, curves: shown(chart)}]));
  listen(chart);
}

const charts = [];
for (const data of document.querySelectorAll('figure > script')) {
  const figure = data.parentNode, picture = figure.querySelector('svg'), {x, charts: mine, map, height} = JSON.parse(data.textContent);
  // It draws neither maps, nor rings and crosses.
  if (map || mine.some(chart => chart.close || chart.curves.some(curve => curve.ring || curve.cross))) {
    for (const chart of mine || []) read(chart, x);
    add_buttons(add(figure, 'div', {class: 'files'}), (map || mine[0]).name, () => picture.cloneNode(true), () => map ? map_table(map) : table(mine));
    continue;
  }
  const together = {x: null, charts: mine};
  for (const chart of mine) {
    chart.height = height;
    read(chart, x);
  }
  const alike = mine.every(chart => chart.x_all + '' + chart.log[0] === mine[0].x_all + '' + mine[0].log[0]);
  for (const chart of mine) {
    chart.view = alike ? together : {x: null, charts: [chart]};
    build(figure, chart);
  }
  picture.remove();
  charts.push(...mine);
}
const first = document.querySelector('.chart');
if (first) add(first.closest('.pair') || first.parentNode, 'p', {class: 'hint'},
  'Click a name to hide its curve. Drag to zoom, double-click to see the whole. Keys: + − ← → 0.');
charts.forEach(draw);
for (const part of document.querySelectorAll('details')) part.ontoggle = () => charts.forEach(draw);  // what is folded has no width
let width = innerWidth;
addEventListener('resize', () => {
  if (innerWidth !== width) charts.forEach(draw);  // on phones, scrolling changes the height alone
  width = innerWidth;
});
