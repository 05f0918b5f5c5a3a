#include "app/study/table/run_table.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <thread>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/results_folder.hpp"
#include "framework/core/check.hpp"
#include "framework/core/file_descriptor.hpp"
#include "framework/core/write_lock.hpp"

namespace tactor {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr const char* layout = "4";  // of the tables below

constexpr const char* schema = R"(
CREATE TABLE identity(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE names(run INTEGER PRIMARY KEY, graph TEXT NOT NULL, configuration TEXT NOT NULL, seed TEXT NOT NULL,
                   content TEXT NOT NULL);
CREATE TABLE runs(run INTEGER PRIMARY KEY REFERENCES names, status TEXT NOT NULL, message TEXT NOT NULL,
                  title TEXT NOT NULL, duration_s REAL, may_differ INTEGER NOT NULL, more TEXT NOT NULL);
CREATE TABLE run_times(run INTEGER PRIMARY KEY REFERENCES names, node TEXT NOT NULL, processor TEXT NOT NULL,
                       c_library TEXT NOT NULL, cpu_s REAL, wall_s REAL, peak_memory_MB REAL, control_us REAL,
                       finished TEXT NOT NULL);
CREATE TABLE repeat_times(run INTEGER NOT NULL, repeat INTEGER NOT NULL, cpu_s REAL,
                          PRIMARY KEY(run, repeat)) WITHOUT ROWID;
CREATE TABLE metrics(run INTEGER NOT NULL, place INTEGER NOT NULL, name TEXT NOT NULL, value REAL,
                     PRIMARY KEY(run, place)) WITHOUT ROWID;
CREATE TABLE declared(name TEXT PRIMARY KEY, unit TEXT NOT NULL, better TEXT NOT NULL, doc TEXT NOT NULL,
                      missing TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE costs(run INTEGER NOT NULL, place INTEGER NOT NULL, node TEXT NOT NULL, type TEXT NOT NULL,
                   role TEXT NOT NULL, steps INTEGER, missed_ticks INTEGER, PRIMARY KEY(run, place)) WITHOUT ROWID;
CREATE TABLE step_times(run INTEGER NOT NULL, place INTEGER NOT NULL, median_us REAL, p99_us REAL, total_s REAL,
                        PRIMARY KEY(run, place)) WITHOUT ROWID;
CREATE TABLE curves(run INTEGER NOT NULL, name TEXT NOT NULL, time BLOB, value BLOB, PRIMARY KEY(run, name)) WITHOUT ROWID;
)";

const char* word(RunStatus status) {
  switch (status) {
    case RunStatus::done:
      return "done";
    case RunStatus::failed:
      return "failed";
    case RunStatus::refused:
      return "refused";
  }
  TACTOR_DEMAND(false);
}

RunStatus status_of(const std::string& text) {
  return text == "done" ? RunStatus::done : text == "refused" ? RunStatus::refused : RunStatus::failed;
}

/// A prepared statement.
class Statement {
 public:
  Statement(sqlite3* db, const fs::path& path, const char* sql) : db_(db), path_(path) {
    if (sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr) != SQLITE_OK) fail();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  void bind(int i, std::int64_t value) { sqlite3_bind_int64(statement_, i, value); }
  /// What is not a number is kept as nothing.
  void bind(int i, double value) { sqlite3_bind_double(statement_, i, value); }
  void bind(int i, const std::string& value) {
    sqlite3_bind_text(statement_, i, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
  }
  void bind(int i, const std::vector<double>& value) {
    sqlite3_bind_blob64(statement_, i, value.data(), value.size() * sizeof(double), SQLITE_TRANSIENT);
  }
  /// Steps once with the values for its places; true where there is a row.
  template <class... Values>
  bool step(const Values&... values) {
    int i = 0;
    (bind(++i, values), ...);
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) fail();
    return code == SQLITE_ROW;
  }
  template <class... Values>
  void run(const Values&... values) {
    step(values...);
    sqlite3_reset(statement_);
  }
  [[nodiscard]] std::string text(int i) const {
    const auto* bytes = sqlite3_column_text(statement_, i);
    return bytes == nullptr ? std::string()
                            : std::string(reinterpret_cast<const char*>(bytes),
                                          static_cast<std::size_t>(sqlite3_column_bytes(statement_, i)));
  }
  [[nodiscard]] std::int64_t integer(int i) const { return sqlite3_column_int64(statement_, i); }
  [[nodiscard]] double real(int i) const {
    return sqlite3_column_type(statement_, i) == SQLITE_NULL ? std::numeric_limits<double>::quiet_NaN()
                                                             : sqlite3_column_double(statement_, i);
  }
  [[nodiscard]] std::vector<double> reals(int i) const {
    std::vector<double> values(static_cast<std::size_t>(sqlite3_column_bytes(statement_, i)) / sizeof(double));
    if (!values.empty()) std::memcpy(values.data(), sqlite3_column_blob(statement_, i), values.size() * sizeof(double));
    return values;
  }

 private:
  [[noreturn]] void fail() const { throw RunError(fmt::format("{}: {}", path_.string(), sqlite3_errmsg(db_))); }
  sqlite3* db_;
  const fs::path& path_;
  sqlite3_stmt* statement_ = nullptr;
};

std::string more_of(const RunResult& result) {
  Json json{{"chosen", Json::array()}, {"left_out", Json::array()}};
  for (const Chosen& c : result.chosen) json["chosen"].push_back({c.node, c.asked, c.type, c.why});
  for (const LeftOut& l : result.left_out) json["left_out"].push_back({l.what, l.why});
  if (!result.reference.too_coarse.empty()) json["reference_too_coarse"] = result.reference.too_coarse;
  json["devices"] = result.devices;
  json["no_force"] = Json::array();
  for (const NoForce& n : result.no_force) json["no_force"].push_back({n.device, n.reason, n.count, n.of, n.text});
  return json.dump();
}

void read_more(const std::string& text, RunResult& result) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return;
  for (const Json& c : json.value("chosen", Json::array())) result.chosen.push_back({c[0], c[1], c[2], c[3]});
  for (const Json& l : json.value("left_out", Json::array())) result.left_out.push_back({l[0], l[1]});
  result.reference.too_coarse = json.value("reference_too_coarse", "");
  result.devices = json.value("devices", std::size_t{0});
  for (const Json& n : json.value("no_force", Json::array())) result.no_force.push_back({n[0], n[1], n[2], n[3], n[4]});
}

}  // namespace

/// The open file, and the lock that keeps other processes from writing it.
struct RunTable::Database {
  const fs::path& path;
  sqlite3* db = nullptr;
  std::optional<FileLock> lock;

  explicit Database(const fs::path& file) : path(file) {}
  ~Database() { sqlite3_close_v2(db); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  [[nodiscard]] LockAnswer region_lock() const {
    const FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
    return file ? ask_for_lock(file.number(), LockKind::of_region) : LockAnswer::taken;
  }
  static int wait_for_reader(void* /*nothing*/, int tries) {
    constexpr int most_tries = 500;
    if (tries >= most_tries || is_interrupted()) return 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return 1;
  }
  void take_lock() { lock.emplace(path.string() + ".lock", path.string() + ": expected a table"); }
  void execute(const char* sql) const {
    const int code = sqlite3_exec(db, sql, nullptr, nullptr, nullptr);
    if (code == SQLITE_NOTADB) {
      throw InputError(
          fmt::format("{}: expected a table of runs, found a file of another kind; --overwrite begins anew, "
                      "--out keeps both",
                      path.string()));
    }
    if (code != SQLITE_OK) {
      throw RunError(fmt::format("{}: {}", path.string(), sqlite3_errmsg(db)));
    }
  }
  void open_file() {
    // Where the file system has no locks, SQLite could open nothing. `lock` keeps other writers away there too.
    const bool has_locks = region_lock() != LockAnswer::none;
    constexpr int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    if (sqlite3_open_v2(path.c_str(), &db, flags, has_locks ? nullptr : "unix-none") != SQLITE_OK) {
      throw RunError(fmt::format("cannot open {}: {}", path.string(), sqlite3_errmsg(db)));
    }
    // Readers may look at any time, and a command that is to end does not wait for them.
    sqlite3_busy_handler(db, wait_for_reader, nullptr);
    if (!has_locks) execute("PRAGMA locking_mode=EXCLUSIVE;");  // WAL without it needs memory that is shared by locks
    execute("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;");
    constexpr int longest = 256 << 20;  // bytes of a value
    sqlite3_limit(db, SQLITE_LIMIT_LENGTH, longest);
  }

  /// How many runs are planned.
  [[nodiscard]] std::size_t size() const {
    Statement count(db, path, "SELECT count(*) FROM names");
    count.step();
    return static_cast<std::size_t>(count.integer(0));
  }

  [[nodiscard]] std::vector<bool> finished() const {
    std::vector<bool> there(size(), false);
    Statement runs(db, path, "SELECT run FROM runs");
    while (runs.step()) there[number_of(runs.integer(0), there.size())] = true;
    return there;
  }

  /// The number of a run, of which `count` are planned.
  [[nodiscard]] std::size_t number_of(std::int64_t run, std::size_t count) const {
    if (run >= 0 && static_cast<std::uint64_t>(run) < count) return static_cast<std::size_t>(run);
    throw RunError(fmt::format("{}: the table is damaged: it has a run {} of {}", path.string(), run, count));
  }

  void make(const TableIdentity& identity, const std::vector<RunName>& runs) const {
    execute("BEGIN");
    execute(schema);
    Statement meta(db, path, "INSERT INTO identity VALUES(?, ?)");
    for (const auto& [key, value] : pairs(identity)) meta.run(key, value);
    Statement name(db, path, "INSERT INTO names VALUES(?, ?, ?, ?, ?)");
    for (std::size_t i = 0; i < runs.size(); ++i) {
      name.run(static_cast<std::int64_t>(i), runs[i].graph, runs[i].configuration, std::to_string(runs[i].seed),
               runs[i].content);
    }
    execute("COMMIT");
  }

  static std::vector<std::pair<std::string, std::string>> pairs(const TableIdentity& identity) {
    return {{"layout", layout},
            {"title", identity.title},
            {"study", identity.study},
            {"options", identity.options},
            {"program", identity.program}};
  }

  /// The SQL of all that a file defines, by kind and name.
  static std::map<std::string, std::string> definitions(sqlite3* db, const fs::path& path) {
    std::map<std::string, std::string> found;
    Statement all(db, path,
                  "SELECT type || ' ' || name, ifnull(sql, '') FROM sqlite_schema WHERE name NOT GLOB 'sqlite_*'");
    while (all.step()) found[all.text(0)] = all.text(1);
    return found;
  }

  /// How the file's definitions differ from the schema; empty where they do not. A view may go on for ever, a column
  /// may compute what fills the memory, and a trigger does what its writer wants with what is added.
  [[nodiscard]] std::string foreign_definition() const {
    const fs::path memory(":memory:");
    Database ours(memory);
    sqlite3_open(memory.c_str(), &ours.db);
    ours.execute(schema);
    const std::map<std::string, std::string> expected = definitions(ours.db, path), found = definitions(db, path);
    for (const auto& [what, sql] : found) {
      const auto own = expected.find(what);
      if (own == expected.end())
        return fmt::format("it holds the {}, which no study makes; drop it to keep the runs", what);
      if (own->second != sql) return "it was written by another version of tactor";
    }
    return found.size() == expected.size() ? "" : "it lacks tables of a study";
  }

  /// What keeps the runs of the file from being gone on with; empty where nothing does.
  [[nodiscard]] std::string difference(const TableIdentity& identity, const std::vector<RunName>& runs) const {
    Statement tables(db, path, "SELECT count(*) FROM sqlite_master WHERE name IN ('identity', 'names', 'runs')");
    tables.step();
    if (tables.integer(0) != 3) return "it holds no runs of a study";
    if (std::string what = foreign_definition(); !what.empty()) return what;
    std::map<std::string, std::string> found;
    Statement meta(db, path, "SELECT key, value FROM identity");
    while (meta.step()) found[meta.text(0)] = meta.text(1);
    if (found["layout"] != layout) return "it was written by another version of tactor";
    if (found["study"] != identity.study) return "the study has changed since";
    if (found["options"] != identity.options) return "the options of the command line were different";
    if (found["program"] != identity.program) return "the program has changed since";
    std::size_t i = 0;
    Statement name(db, path, "SELECT graph, configuration, seed, content FROM names ORDER BY run");
    for (; name.step(); ++i) {
      const std::string run =
          fmt::format("{}{}{}, seed {}", name.text(0), name.text(1).empty() ? "" : " ", name.text(1), name.text(2));
      if (i >= runs.size() || name.text(0) != runs[i].graph || name.text(1) != runs[i].configuration ||
          name.text(2) != std::to_string(runs[i].seed)) {
        return "its runs are others: " + run;
      }
      const bool both_known = !name.text(3).empty() && !runs[i].content.empty();
      if (both_known && name.text(3) != runs[i].content)
        return "the graph, or a file that it names, has changed since: " + run;
    }
    return i == runs.size() ? "" : "its runs are others";
  }
};

RunTable::RunTable(fs::path path, TableMode mode, const TableIdentity& identity, const std::vector<RunName>& runs)
    : path_(std::move(path)), db_(std::make_unique<Database>(path_)) {
  std::error_code ignored;
  const bool exists = is_taken(path_);
  if (exists && mode == TableMode::create) {
    throw InputError(
        fmt::format("{}: expected no runs there yet, found some; --resume continues them, --overwrite starts anew",
                    path_.string()));
  }
  db_->take_lock();
  if (mode == TableMode::overwrite) {
    for (const char* end : {"", "-wal", "-shm"}) fs::remove(path_.string() + end, ignored);
  }
  db_->open_file();
  if (exists && mode == TableMode::resume) {
    Statement tables(db_->db, path_, "SELECT count(*) FROM sqlite_master");
    tables.step();
    // A process that ended before its first transaction leaves an empty file.
    if (tables.integer(0) > 0) {
      const std::string difference = db_->difference(identity, runs);
      if (difference.empty()) {
        db_->execute(
            "DELETE FROM run_times WHERE run IN (SELECT run FROM runs WHERE may_differ);"
            "DELETE FROM runs WHERE may_differ");
        return;
      }
      throw InputError(
          fmt::format("{}: expected the runs of this study, found {}; --overwrite begins anew, --out keeps both",
                      path_.string(), difference));
    }
  }
  db_->make(identity, runs);
  is_new_ = true;
}

RunTable::~RunTable() = default;

std::vector<bool> RunTable::finished() const {
  return db_->finished();
}

namespace {

/// The statements that write a run, prepared once for many.
class RunInserts {
 public:
  RunInserts(sqlite3* db, const fs::path& path)
      : row_(db, path, "INSERT INTO runs VALUES(?, ?, ?, ?, ?, ?, ?)"),
        times_(db, path, "INSERT INTO run_times VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)"),
        repeat_(db, path, "INSERT INTO repeat_times VALUES(?, ?, ?)"),
        metric_(db, path, "INSERT INTO metrics VALUES(?, ?, ?, ?)"),
        declared_(db, path, "INSERT OR IGNORE INTO declared VALUES(?, ?, ?, ?, ?)"),
        cost_(db, path, "INSERT INTO costs VALUES(?, ?, ?, ?, ?, ?, ?)"),
        step_time_(db, path, "INSERT INTO step_times VALUES(?, ?, ?, ?, ?)"),
        curve_(db, path, "INSERT INTO curves VALUES(?, ?, ?, ?)") {}

  void add(const RunRecord& record) {
    const auto run = static_cast<std::int64_t>(record.number);
    const RunResult& result = record.result;
    row_.run(run, std::string(word(record.status)), record.message, result.title, result.duration_s,
             std::int64_t{record.may_differ}, more_of(result));
    times_.run(run, record.ran_on.node, record.ran_on.processor, record.ran_on.c_library, result.cpu_s, result.wall_s,
               result.peak_memory_MB, record.control_us, record.finished);
    for (std::size_t i = 0; i < record.cpu_s.size(); ++i) {
      repeat_.run(run, static_cast<std::int64_t>(i), record.cpu_s[i]);
    }
    std::int64_t place = 0;
    for (const auto& [name, value] : result.metrics) metric_.run(run, place++, name, value);
    for (const auto& [name, info] : result.declared) {
      if (!known_.insert(name).second) continue;
      declared_.run(name, info.unit, std::string(name_of(info.better)), info.doc, info.missing);
    }
    place = 0;
    for (const NodeCost& node : result.nodes) {
      cost_.run(run, place, node.node, node.type, std::string(name_of(node.role)),
                static_cast<std::int64_t>(node.steps), static_cast<std::int64_t>(node.missed_ticks));
      step_time_.run(run, place++, node.median_us, node.p99_us, node.total_s);
    }
    for (const Series& series : result.series) curve_.run(run, series.name, series.time, series.value);
  }

 private:
  Statement row_, times_, repeat_, metric_, declared_, cost_, step_time_, curve_;
  std::set<std::string> known_;  // metrics that have been declared
};

}  // namespace

void RunTable::add(std::span<const RunRecord> records) {
  db_->execute("BEGIN IMMEDIATE");
  try {
    RunInserts inserts(db_->db, path_);
    for (const RunRecord& record : records) inserts.add(record);
    db_->execute("COMMIT");
  } catch (...) {
    sqlite3_exec(db_->db, "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

void RunTable::tell(const Provenance& provenance) {
  Statement(db_->db, path_, "INSERT OR REPLACE INTO identity VALUES(?, ?)")
      .run("provenance " + provenance.date, provenance_text(provenance));
}

void RunTable::save_as(const fs::path& file) const {
  Statement(db_->db, path_, "VACUUM INTO ?").step(file.string());
}

std::vector<RunRecord> RunTable::read() const {
  std::vector<RunRecord> records;
  std::map<std::int64_t, std::size_t> at;
  const std::size_t planned = db_->size();
  Statement runs(
      db_->db, path_,
      "SELECT run, status, message, title, duration_s, cpu_s, wall_s, peak_memory_MB, control_us, more, graph, "
      "seed, may_differ, node, processor, c_library, finished FROM runs NATURAL JOIN names NATURAL JOIN run_times "
      "ORDER BY run");
  while (runs.step()) {
    RunRecord record;
    record.number = db_->number_of(runs.integer(0), planned);
    record.status = status_of(runs.text(1));
    record.message = runs.text(2);
    RunResult& result = record.result;
    result.title = runs.text(3);
    result.duration_s = runs.real(4);
    result.cpu_s = runs.real(5);
    result.wall_s = runs.real(6);
    result.peak_memory_MB = runs.real(7);
    record.control_us = runs.real(8);
    read_more(runs.text(9), result);
    result.graph = runs.text(10);
    result.seed = std::stoull(runs.text(11));
    record.may_differ = runs.integer(12) != 0;
    record.ran_on = {runs.text(13), runs.text(14), runs.text(15)};
    record.finished = runs.text(16);
    at[runs.integer(0)] = records.size();
    records.push_back(std::move(record));
  }
  Statement repeats(db_->db, path_, "SELECT run, cpu_s FROM repeat_times ORDER BY run, repeat");
  while (repeats.step()) records[at.at(repeats.integer(0))].cpu_s.push_back(repeats.real(1));
  Statement metrics(db_->db, path_, "SELECT run, name, value FROM metrics ORDER BY run, place");
  while (metrics.step()) {
    records[at.at(metrics.integer(0))].result.metrics.emplace_back(metrics.text(1), metrics.real(2));
  }
  Statement costs(db_->db, path_,
                  "SELECT run, node, type, role, steps, missed_ticks, median_us, p99_us, total_s FROM costs NATURAL "
                  "JOIN step_times "
                  "ORDER BY run, place");
  while (costs.step()) {
    records[at.at(costs.integer(0))].result.nodes.push_back(
        {costs.text(1), costs.text(2), role_of(costs.text(3)), static_cast<std::uint64_t>(costs.integer(4)),
         static_cast<std::uint64_t>(costs.integer(5)), costs.real(6), costs.real(7), costs.real(8)});
  }
  Statement curves(db_->db, path_, "SELECT run, name, time, value FROM curves");
  while (curves.step()) {
    records[at.at(curves.integer(0))].result.series.push_back({curves.text(1), "", curves.reals(2), curves.reals(3)});
  }
  return records;
}

MetricMap RunTable::declared() const {
  MetricMap found;
  Statement rows(db_->db, path_, "SELECT name, unit, better, doc, missing FROM declared");
  while (rows.step()) {
    const std::string better = rows.text(2);
    MetricInfo info{rows.text(0), rows.text(1), rows.text(3)};
    for (const Better one : {Better::lower, Better::higher, Better::near_zero, Better::neither}) {
      if (better == name_of(one)) info.better = one;
    }
    info.missing = rows.text(4);
    found.emplace(rows.text(0), std::move(info));
  }
  return found;
}

}  // namespace tactor
