// Saves a figure as a file: SVG and PDF as it is seen, on a light page and with its names, CSV with all values.
const SEEN = ['fill', 'stroke', 'stroke-width', 'stroke-dasharray', 'stroke-linejoin', 'font-family', 'font-size'];

// A chart as a picture that needs no style of the page.
function picture_of(chart) {
  const {svg} = chart, width = +svg.getAttribute('width');
  document.documentElement.classList.add('paper');
  const group = add(svg, 'g', {class: 'names'});
  let x = LEFT, y = chart.height + 12;
  for (const curve of shown(chart).filter(curve => curve.name && curve.parts.length)) {
    const text = add(group, 'text', {}, curve.name), long = text.getComputedTextLength() + 36;
    if (x > LEFT && x + long > width) [x, y] = [LEFT, y + 18];
    text.setAttribute('x', x + 26);
    text.setAttribute('y', y);
    add_sample(group, curve, x, y - 4);
    x += long;
  }
  const copy = svg.cloneNode(true), seen = svg.querySelectorAll('*');
  copy.querySelectorAll('*').forEach((one, i) => {
    const style = getComputedStyle(seen[i]);
    for (const name of SEEN) if (one.localName !== 'svg') one.setAttribute(name, style.getPropertyValue(name));
    one.removeAttribute('style');
    one.removeAttribute('class');
  });
  group.remove();
  document.documentElement.classList.remove('paper');
  const height = group.childNodes.length ? y + 8 : chart.height;
  for (const [name, value] of Object.entries({height, viewBox: `0 0 ${width} ${height}`})) copy.setAttribute(name, value);
  return copy;
}

// A row for each value; null: nothing stands there.
function table(charts) {
  const bars = ['x_low', 'x_high', 'y_low', 'y_high'], several = charts.length > 1, [first] = charts;
  const with_bars = charts.some(chart => chart.curves.some(curve => curve.x_low));
  const head = several ? ['chart', 'curve', 'x', 'y'] : ['curve', first.x, first.y];
  return [head.concat(with_bars ? bars : []), ...charts.flatMap(chart => chart.curves.flatMap(curve => curve.x.map((x, i) => [
    ...several ? [chart.name] : [], curve.name, x, curve.y[i], ...with_bars ? bars.map(name => curve[name]?.[i]) : []])))];
}

const map_table = map => [[map.x_label, map.y_label, 'kind'],
  ...map.kind.flatMap((row, i) => row.flatMap((kind, k) => kind < 0 ? [] : [[map.x[k], map.y[i], map.kinds[kind][0]]]))];

function save(file, type, text) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([text], {type}));
  link.download = file;
  link.click();
}

// The browser's own dialogue for printing writes the PDF, with its fonts.
function print_alone(picture) {
  const {width, height} = picture.viewBox.baseVal;
  const size = add(document.head, 'style', {}, `@page{size:${width}px ${height}px;margin:0}`);
  const sheet = add(document.body, 'div', {class: 'sheet'});
  sheet.append(picture);
  document.body.classList.add('printed');
  onafterprint = () => {
    size.remove();
    sheet.remove();
    document.body.classList.remove('printed');
  };
  print();
}

function add_buttons(parent, name, picture, rows) {
  const file = name.replace(/[^\w.-]+/g, '_');
  const field = value => /[",\r\n]/.test(value ??= '') ? '"' + value.replaceAll('"', '""') + '"' : value;
  const ways = {
    SVG: () => save(file + '.svg', 'image/svg+xml', new XMLSerializer().serializeToString(picture())),
    PDF: () => print_alone(picture()),
    CSV: () => save(file + '.csv', 'text/csv', rows().map(row => row.map(field).join() + '\n').join('')),
  };
  for (const way in ways) add(parent, 'button', {class: 'file', title: 'Save this figure as ' + way}, way).onclick = ways[way];
}
