#include "framework/engine/reference.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <deque>

#include "framework/core/check.hpp"
#include "framework/engine/virtual_engine.hpp"
#include "framework/fields/write_fields.hpp"
#include "framework/graph/scene_fields.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Collects the parts of a key, each with its length, so that no two different lists run together.
class KeyText {
 public:
  void add(std::string_view text) {
    text_ += std::to_string(text.size()) + ':';
    text_ += text;
  }
  void add(double value) { add(std::to_string(std::bit_cast<std::uint64_t>(value))); }
  void add(std::int64_t value) { add(std::to_string(value)); }
  void add_file(const fs::path& path) { add(file_key(path)); }
  void add_files(const std::vector<fs::path>& paths) {
    add(static_cast<std::int64_t>(paths.size()));
    for (const fs::path& path : paths) add_file(path);
  }
  void add(const ParamInfo& info, const ParamValue& value) {
    add(info.name);
    if (const auto* b = std::get_if<bool>(&value)) add(std::int64_t{*b});
    if (const auto* i = std::get_if<std::int64_t>(&value)) add(*i);
    if (const auto* d = std::get_if<double>(&value)) add(*d);
    if (const auto* s = std::get_if<std::string>(&value)) {
      if (info.kind == ParamKind::file && !s->empty()) {
        add_files(files_of(info, value));
      } else {
        add(*s);
      }
    }
    if (const auto* list = std::get_if<std::vector<double>>(&value)) {
      add(static_cast<std::int64_t>(list->size()));
      for (const double d : *list) add(d);
    }
    if (const auto* table = std::get_if<Table>(&value)) {
      add(static_cast<std::int64_t>(table->values.size()));
      for (const double d : table->values) add(d);
    }
    if (const auto* mapping = std::get_if<Mapping>(&value)) {
      for (const auto& [from, to] : *mapping) add(from), add(to);
    }
  }
  [[nodiscard]] std::string key() const { return content_key({text_}); }

 private:
  std::string text_;
};

/// The scene as it is written, with the content of its meshes in the place of their paths. The camera draws only.
void add_scene(KeyText& text, Scene scene) {
  scene.camera = {};
  for (Body& body : scene.bodies) {
    if (auto* mesh = std::get_if<MeshShape>(&body.shape)) mesh->file = file_key(mesh->file);
  }
  text.add(FieldWriter::text(scene));
}

/// Keeps what arrives at one reference input.
class Capture {
 public:
  Capture(Dispatcher& dispatcher, std::size_t edge, const MessageType& type, ReferenceStream& stream)
      : tap_(type, {QueuePolicy::drop_newest, 256}), stream_(stream) {
    tap_.when_full([this] { take(); });
    dispatcher.add_arrival_tap(edge, tap_);
  }

  void take() {
    while (const MessageView message = tap_.take()) {
      stream_.stamps.push_back(*message.stamp);
      stream_.payloads.insert(stream_.payloads.end(), message.value, message.value + tap_.type().size);
    }
  }

 private:
  Tap tap_;
  ReferenceStream& stream_;
};

void put(std::string& out, const void* data, std::size_t size) {
  out.append(static_cast<const char*>(data), size);
}

/// Reads from a buffer and remembers whether it ran over the end.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : rest_(bytes) {}
  bool take(void* data, std::size_t size) {
    if (size > rest_.size()) return ok_ = false;
    if (size > 0) std::memcpy(data, rest_.data(), size);
    rest_.remove_prefix(size);
    return true;
  }
  std::uint64_t number() {
    std::uint64_t n = 0;
    take(&n, sizeof n);
    return n;
  }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }
  [[nodiscard]] bool ok() const { return ok_; }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace

bool ReferenceStream::operator==(const ReferenceStream& other) const {
  return stamps.size() == other.stamps.size() && payloads == other.payloads &&
         std::equal(stamps.begin(), stamps.end(), other.stamps.begin(), [](const Stamp& a, const Stamp& b) {
           return a.valid == b.valid && a.produced == b.produced && a.sequence == b.sequence;
         });
}

std::string reference_key(const Plan& plan, const std::vector<fs::path>& libraries) {
  KeyText text;
  text.add(static_cast<std::int64_t>(plan.graph.seed));
  text.add(plan.graph.duration.ns);
  text.add(std::int64_t{plan.torque});
  add_scene(text, plan.graph.scene);
  for (const NodeSpec& node : plan.nodes) {
    text.add(node.name);
    text.add(node.info->type);
    for (std::size_t i = 0; i < node.params.size(); ++i) text.add(node.info->params[i], node.params[i]);
    text.add(node.info->code);
  }
  for (const PlannedEdge& edge : plan.edges) {
    text.add(edge.spec.name());
    text.add(static_cast<std::int64_t>(edge.spec.queue.policy));
    text.add(std::int64_t{edge.spec.queue.capacity});
    text.add(edge.spec.delay.ns);
  }
  for (const fs::path& library : libraries) text.add_file(library);
  return text.key();
}

Reference run_reference(const Plan& plan, const PlanNodes* tested, const std::function<bool(double)>& go_on) {
  VirtualEngine engine(plan);
  if (tested != nullptr) engine.nodes().follow(*tested);
  Reference reference;
  std::deque<Capture> captures;
  for (std::size_t e = 0; e < plan.edges.size(); ++e) {
    const PlannedEdge& edge = plan.edges[e];
    const InputInfo& input = plan.nodes[edge.to].info->inputs[edge.input];
    if (!input.reference) continue;
    captures.emplace_back(engine.dispatcher(), e, *input.type, reference[edge.spec.to_node + "." + edge.spec.to_port]);
  }
  constexpr Duration progress_period{10'000'000};
  const Time end = Time{} + plan.graph.duration;
  engine.start();
  while (engine.now() < end) {
    engine.advance_to(std::min(engine.now() + progress_period, end));
    if (go_on && !go_on(engine.now().seconds() / plan.graph.duration.seconds())) throw RunError("interrupted");
  }
  for (Capture& capture : captures) capture.take();
  return reference;
}

bool must_be_followed(const PlanNodes& nodes) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].must_be_followed()) return true;
  }
  return false;
}

namespace {

std::string in_hz(double rate) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.begin(), text.end(), std::round(10 * rate) / 10, std::chars_format::fixed).ptr;
  return std::string(text.begin(), end) + " Hz";
}

/// The slowest node that steps as often in the reference run as in the run under test, and less often than the others;
/// empty where there is none.
std::string held_node(const Plan& reference, const Plan& tested) {
  const NodeSpec* slowest = nullptr;
  double lowest = reference_rate;
  for (const NodeSpec& node : reference.nodes) {
    const std::optional<double> rate = node.rate();
    if (node.info->sink || !rate) continue;
    const auto own = std::find_if(tested.nodes.begin(), tested.nodes.end(),
                                  [&](const NodeSpec& other) { return other.name == node.name; });
    const bool is_held = own != tested.nodes.end() && rate <= own->rate();
    if (!is_held || *rate >= lowest) continue;
    slowest = &node;
    lowest = *rate;
  }
  if (slowest == nullptr) return {};
  return "the reference run is no finer than the run: node " + slowest->name + " steps at " + in_hz(lowest) +
         " in both, because it can step no faster";
}

}  // namespace

ReferenceRate rate_of(const Reference& reference, const Plan* reference_plan, const Plan& tested, Duration run,
                      const std::function<std::uint64_t(std::size_t edge)>& delivered) {
  constexpr double finer = 1.5;
  struct Arrivals {
    std::string from;  // `node.port`
    double run = 0;    // messages
  };
  std::map<std::string, Arrivals> inputs;
  for (std::size_t e = 0; e < tested.edges.size(); ++e) {
    const EdgeSpec& edge = tested.edges[e].spec;
    if (!reference.contains(edge.to_node + "." + edge.to_port)) continue;
    Arrivals& arrivals = inputs[edge.to_node + "." + edge.to_port];
    arrivals.from = edge.from_node + "." + edge.from_port;
    arrivals.run += static_cast<double>(delivered(e));
  }
  ReferenceRate found;
  if (run.ns <= 0) return found;
  if (reference_plan != nullptr) found.too_coarse = held_node(*reference_plan, tested);
  for (const auto& [input, arrivals] : inputs) {
    const std::vector<Stamp>& stamps = reference.at(input).stamps;
    const auto in_time =
        std::count_if(stamps.begin(), stamps.end(), [&](const Stamp& stamp) { return stamp.valid <= Time{} + run; });
    const double rate = static_cast<double>(in_time) / run.seconds();
    const double of_run = arrivals.run / run.seconds();
    if (found.hz == 0 || rate < found.hz) found.hz = rate;
    if (!found.too_coarse.empty() || rate >= finer * of_run) continue;
    found.too_coarse = (reference_plan == nullptr ? "the recording" : "the reference run") +
                       std::string(" is no finer than the run: ") + arrivals.from + " comes at " + in_hz(rate) +
                       " in it, and at " + in_hz(of_run) + " in the run";
  }
  return found;
}

void set_reference(PlanNodes& tested, const Reference& reference) {
  const Plan& plan = tested.plan();
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    for (const InputInfo& input : plan.nodes[n].info->inputs) {
      if (!input.reference) continue;
      const auto it = reference.find(plan.nodes[n].name + "." + input.name);
      if (it != reference.end()) input.access(tested[n]).set_reference(it->second.stamps, it->second.payloads);
    }
  }
}

std::string to_bytes(const Reference& reference) {
  static_assert(std::is_trivially_copyable_v<Stamp>);
  std::string bytes;
  const auto number = [&bytes](std::uint64_t n) { put(bytes, &n, sizeof n); };
  number(reference.size());
  for (const auto& [name, stream] : reference) {
    number(name.size());
    put(bytes, name.data(), name.size());
    number(stream.stamps.size());
    number(stream.payloads.size());
    put(bytes, stream.stamps.data(), stream.stamps.size() * sizeof(Stamp));
    put(bytes, stream.payloads.data(), stream.payloads.size());
  }
  return bytes;
}

std::optional<Reference> reference_from_bytes(std::string_view bytes) {
  Cursor cursor(bytes);
  Reference reference;
  const std::uint64_t streams = cursor.number();
  for (std::uint64_t s = 0; s < streams && cursor.ok(); ++s) {
    std::string name(std::min<std::uint64_t>(cursor.number(), cursor.left()), '\0');
    cursor.take(name.data(), name.size());
    ReferenceStream& stream = reference[name];
    const std::uint64_t count = cursor.number();
    const std::uint64_t size = cursor.number();
    if (count > cursor.left() / sizeof(Stamp) || size > cursor.left()) return std::nullopt;
    stream.stamps.resize(count);
    stream.payloads.resize(size);
    cursor.take(stream.stamps.data(), count * sizeof(Stamp));
    cursor.take(stream.payloads.data(), size);
  }
  if (!cursor.ok() || cursor.left() != 0) return std::nullopt;
  return reference;
}

namespace {

/// Whether every stream arrives at an input of the plan with one payload of that input's type for each stamp.
bool is_of(const Reference& reference, const Plan& plan) {
  std::map<std::string, std::size_t> sizes;
  for (const PlannedEdge& edge : plan.edges) {
    sizes[edge.spec.to_node + "." + edge.spec.to_port] = plan.nodes[edge.to].info->inputs[edge.input].type->size;
  }
  return std::all_of(reference.begin(), reference.end(), [&](const auto& named) {
    const auto size = sizes.find(named.first);
    const ReferenceStream& stream = named.second;
    return size != sizes.end() && stream.payloads.size() / size->second == stream.stamps.size() &&
           stream.payloads.size() % size->second == 0;
  });
}

}  // namespace

ReferenceCache::ReferenceCache(fs::path folder) : cache_("ref", layout, std::move(folder)) {}

ReferenceCache::Found ReferenceCache::load(const std::string& key, const Plan& plan) const {
  DiskCache::Found found = cache_.load(key);
  if (!found.bytes) return {std::nullopt, std::move(found.note)};
  std::optional<Reference> reference = reference_from_bytes(found.bytes->view());
  if (!reference || !is_of(*reference, plan)) {
    reference.reset();
    found.note = cache_.file(key).string() +
                 ": the cached file holds no reference run of this graph; computed again and replaced";
  }
  return {std::move(reference), std::move(found.note)};
}

std::string ReferenceCache::store(const std::string& key, const Reference& reference) const {
  return cache_.store(key, to_bytes(reference));
}

}  // namespace tactor
