#include "devices/usb/emulator/emulation.hpp"

#include <sstream>

namespace tactor {

namespace {

void put(std::ostream& out, const char* key, const std::vector<Flag>& flags) {
  for (const Flag& f : flags) out << key << ' ' << f.field << ' ' << f.bit << ' ' << f.above << '\n';
}

void put(std::ostream& out, const char* key, const std::vector<ReportField>& fields) {
  for (const ReportField& f : fields) {
    out << key << ' ' << f.at << ' ' << static_cast<int>(f.type) << ' ' << static_cast<int>(f.order) << '\n';
  }
}

/// Reads the value of one key; false where it cannot be.
class Line {
 public:
  Line(std::istringstream& in, Emulation& e) : in_(in), e_(e) {}

  bool read(const std::string& key) {
    if (key == "kind") return rest(e_.kind);
    if (key == "path") return rest(e_.path);
    if (key == "name") return rest(e_.name);
    if (key == "serial") return rest(e_.serial);
    if (key == "state") return rest(e_.state);
    if (key == "trace") return rest(e_.trace);
    if (key == "control") return rest(e_.control);
    if (key == "geometry") return rest(e_.geometry);
    if (key == "ids") return get(e_.vendor) && get(e_.product);
    if (key == "bulk") return get(e_.bulk);
    if (key == "asks_first") return get(e_.asks_first);
    if (key == "watchdog") return get(e_.watchdog);
    if (key == "sizes") return get(e_.input.size) && get(e_.output.size);
    if (key == "in") return field(e_.input.fields, e_.input.size);
    if (key == "out") return field(e_.output.fields, e_.output.size);
    if (key == "axis") return axis();
    if (key == "button_flag") return flag(e_.input.buttons);
    if (key == "fault_flag") return flag(e_.input.faults);
    if (key == "number") return number();
    if (key == "start") return get(e_.start.x) && get(e_.start.y) && get(e_.start.z);
    if (key == "hand") return hand();
    if (key == "point") return point();
    if (key == "fault") return fault();
    return false;
  }

 private:
  template <class T>
  bool get(T& value) {
    return static_cast<bool>(in_ >> value);
  }
  bool rest(std::string& text) {
    std::getline(in_ >> std::ws, text);
    return true;
  }
  bool field(std::vector<ReportField>& fields, std::size_t size) {
    ReportField f;
    int type = 0, order = 0;
    if (!get(f.at) || !get(type) || !get(order) || type < 0 || type > 6 || order < 0 || order > 1) return false;
    f.type = static_cast<FieldType>(type);
    f.order = static_cast<ByteOrder>(order);
    fields.push_back(f);
    return f.at + f.size() <= size;
  }
  bool axis() {
    AxisInput in;
    AxisOutput out;
    if (!get(in.field) || !get(in.scale) || !get(in.offset) || !get(out.field) || !get(out.scale) || !get(out.limit)) {
      return false;
    }
    e_.input.axes.push_back(in);
    e_.output.axes.push_back(out);
    return in.field < e_.input.fields.size() && out.field < e_.output.fields.size() && in.scale != 0 &&
           out.scale != 0 && e_.input.axes.size() <= 6;
  }
  bool flag(std::vector<Flag>& flags) {
    Flag f;
    if (!get(f.field) || !get(f.bit) || !get(f.above)) return false;
    flags.push_back(f);
    return f.field < e_.input.fields.size() && f.bit < 32;
  }
  bool number() {
    double value = 0;
    if (!get(value)) return false;
    e_.numbers.push_back(value);
    return true;
  }
  bool hand() {
    HandModel& h = e_.hand;
    return get(h.mass) && get(h.damping) && get(h.stiffness) && get(h.friction) && get(h.hold) && get(h.approach) &&
           h.mass > 0 && h.approach > 0;
  }
  bool point() {
    double t = 0;
    Vec3 p;
    if (!get(t) || !get(p.x) || !get(p.y) || !get(p.z)) return false;
    e_.hand.times.push_back(t);
    e_.hand.points.push_back(p);
    return true;
  }
  bool fault() {
    std::string text;
    FaultOrder order;
    if (!rest(text) || !parse_fault_order(text, order).empty()) return false;
    e_.faults.push_back(order);
    return true;
  }

  std::istringstream& in_;
  Emulation& e_;
};

}  // namespace

std::string to_text(const Emulation& e) {
  std::ostringstream out;
  out.precision(17);
  out << "kind " << e.kind << "\npath " << e.path << "\nids " << e.vendor << ' ' << e.product << "\nname " << e.name
      << "\nserial " << e.serial << "\nbulk " << e.bulk << "\nasks_first " << e.asks_first << "\nwatchdog "
      << e.watchdog << "\nsizes " << e.input.size << ' ' << e.output.size << '\n';
  put(out, "in", e.input.fields);
  put(out, "out", e.output.fields);
  for (std::size_t i = 0; i < e.input.axes.size(); ++i) {
    const AxisInput& a = e.input.axes[i];
    const AxisOutput& b = e.output.axes[i];
    out << "axis " << a.field << ' ' << a.scale << ' ' << a.offset << ' ' << b.field << ' ' << b.scale << ' ' << b.limit
        << '\n';
  }
  put(out, "button_flag", e.input.buttons);
  put(out, "fault_flag", e.input.faults);
  out << "geometry " << e.geometry << '\n';
  for (const double n : e.numbers) out << "number " << n << '\n';
  out << "start " << e.start.x << ' ' << e.start.y << ' ' << e.start.z << '\n';
  const HandModel& h = e.hand;
  out << "hand " << h.mass << ' ' << h.damping << ' ' << h.stiffness << ' ' << h.friction << ' ' << h.hold << ' '
      << h.approach << '\n';
  for (std::size_t i = 0; i < h.points.size(); ++i) {
    out << "point " << h.times[i] << ' ' << h.points[i].x << ' ' << h.points[i].y << ' ' << h.points[i].z << '\n';
  }
  for (const FaultOrder& f : e.faults) out << "fault " << to_text(f) << '\n';
  if (!e.state.empty()) out << "state " << e.state << '\n';
  if (!e.trace.empty()) out << "trace " << e.trace << '\n';
  if (!e.control.empty()) out << "control " << e.control << '\n';
  return out.str();
}

std::string read_emulation(const std::string& text, Emulation& emulation) {
  emulation = {};
  std::istringstream lines(text);
  int count = 0;
  for (std::string line; std::getline(lines, line);) {
    ++count;
    std::istringstream in(line);
    std::string key;
    if (!(in >> key)) continue;
    if (!Line(in, emulation).read(key)) return "line " + std::to_string(count) + ": " + line;
  }
  if (emulation.path.empty()) return "no path";
  if (make_arm_geometry(emulation.geometry, emulation.numbers) == nullptr) return "no geometry " + emulation.geometry;
  return {};
}

}  // namespace tactor
