#include "nodes/source/trajectory.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "framework/core/check.hpp"
#include "framework/core/units.hpp"
#include "framework/core/value_error.hpp"
#include "framework/node/declare.hpp"
#include "nodes/source/csv_table.hpp"

namespace tactor {

namespace {

constexpr std::array<std::string_view, 7> column_names{"t", "x", "y", "z", "rx", "ry", "rz"};
constexpr std::array<std::string_view, 7> column_units{"s", "m", "m", "m", "rad", "rad", "rad"};

WayPoint way_point(const std::array<double, 7>& row) {
  return {row[0], {row[1], row[2], row[3]}, {row[4], row[5], row[6]}};
}

std::vector<WayPoint> points_of_table(const Table& table) {
  std::vector<WayPoint> points;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    std::array<double, 7> row{};
    for (std::size_t c = 0; c < row.size(); ++c) row[c] = table.at(i, c);
    points.push_back(way_point(row));
  }
  return points;
}

std::vector<WayPoint> points_of_file(const std::filesystem::path& path) {
  const CsvTable table = read_csv(path);
  std::vector<std::size_t> target(table.columns.size());
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const CsvColumn& column = table.columns[c];
    const auto at = std::find(column_names.begin(), column_names.end(), column.name);
    const std::string place = path.string() + ":1: column '" + column.heading + "'";
    if (at == column_names.end()) {
      throw InputError(place + " is not one of t x y z rx ry rz with a unit, for example t_s or x [mm]");
    }
    target[c] = static_cast<std::size_t>(at - column_names.begin());
    const std::string unit(column_units[target[c]]);
    if (!column.unit) throw InputError(place + " names no unit; write " + std::string(*at).append("_").append(unit));
    if (column.unit->dimension != parse_unit(unit)->dimension) {
      throw InputError(place + " is in " + describe(column.unit->dimension) + ", expected a unit such as " + unit);
    }
    for (std::size_t before = 0; before < c; ++before) {
      if (target[before] == target[c]) throw InputError(place + " gives " + std::string(*at) + " a second time");
    }
  }
  if (!table.find("t")) throw InputError(path.string() + ":1: there is no column t, for example t_s");
  std::vector<WayPoint> points;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    std::array<double, 7> row{};
    for (std::size_t c = 0; c < target.size(); ++c) row[target[c]] = table.at(i, c) * table.columns[c].unit->scale;
    points.push_back(way_point(row));
    if (i > 0 && points[i].t <= points[i - 1].t) {
      throw InputError(table.place(i) + ": the times of way-points must increase");
    }
  }
  return points;
}

/// A path that begins again is laid out with that many passes on either side of one that stands for all later ones, so
/// that what a spline does at its ends has died away there.
constexpr int passes_beside = 4;

/// The way-points of all passes, each `after` s later. Where the first point of a pass comes at the time of the last
/// one of the pass before, it is left out.
std::vector<WayPoint> repeated(const std::vector<WayPoint>& points, double after) {
  if (points.empty() || after <= 0) return points;
  if (after < points.back().t) {
    throw ValueError("repeat_after", "repeat_after: expected at least the time of the last way-point, " +
                                         std::to_string(points.back().t) + " s, found " + std::to_string(after) + " s");
  }
  // Sums of times are not exact: nearer than that, two points are at one time.
  constexpr double same_time = 1e-6;
  const WayPoint &first = points.front(), &last = points.back();
  const bool returns = first.p_WH == last.p_WH && first.r_WH == last.r_WH;
  if (after + first.t < last.t + same_time && !returns) {
    throw ValueError("repeat_after",
                     "repeat_after: expected more than the time of the last way-point, " + std::to_string(last.t) +
                         " s, which leaves time for the way to the first one, found " + std::to_string(after) + " s");
  }
  std::vector<WayPoint> all = points;
  for (int pass = 1; pass <= 2 * passes_beside; ++pass) {
    for (WayPoint point : points) {
      point.t += pass * after;
      if (point.t > all.back().t + same_time) all.push_back(point);
    }
  }
  return all;
}

Path make_path(const TrajectorySource::Params& params, const std::string& name) {
  const bool table = params.points.rows() > 0;
  if (table == !params.file.empty()) {
    throw ValueError("file",
                     name + ": exactly one of points and file is expected, found " + (table ? "both" : "neither"));
  }
  return about(table ? "points" : "file", [&] {
    const std::vector<WayPoint> points = table ? points_of_table(params.points) : points_of_file(params.file);
    return Path(repeated(points, params.repeat_after.seconds()), params.interpolation,
                table ? name + ": points" : params.file.string());
  });
}

/// At even times, and at every way-point unless they are too many to be far apart.
HandPath hand_path(const TrajectorySource::Params& params, const NodeContext& context) {
  constexpr std::size_t steps = 2000;
  const TrajectorySource source(params, context);
  // Without an end of the run, one pass along the way-points shows the whole motion.
  const double end = context.duration == until_stopped ? source.path().points().back().t : context.duration.seconds();
  std::vector<double> times;
  for (std::size_t i = 0; i <= steps; ++i) times.push_back(end * static_cast<double>(i) / steps);
  if (source.path().points().size() <= steps) {
    for (const WayPoint& point : source.path().points()) {
      if (point.t > 0 && point.t < end) times.push_back(point.t);
    }
    std::sort(times.begin(), times.end());
  }
  HandPath path;
  for (const double t : times) path.X_WH.push_back(source.at(t).X_WH);
  return path;
}

}  // namespace

TrajectorySource::TrajectorySource(const Params& params, const NodeContext& context)
    : rotates_(context.torque),
      halt_(params.halt.ns > 0 ? std::optional(params.halt.seconds()) : std::nullopt),
      repeat_after_(params.repeat_after.seconds()),
      path_(make_path(params, context.name)),
      tremor_(params.tremor_amplitude, params.tremor_low, params.tremor_high, params.tremor_components, context.seed) {
  if (params.tremor_low > params.tremor_high) {
    throw ValueError("tremor_low", context.name + ": tremor_low must not be above tremor_high, found " +
                                       std::to_string(params.tremor_low) + " Hz and " +
                                       std::to_string(params.tremor_high) + " Hz");
  }
}

NodeInfo TrajectorySource::declare() {
  std::vector<ColumnInfo> columns;
  for (std::size_t i = 0; i < column_names.size(); ++i) {
    columns.push_back({std::string(column_names[i]), std::string(column_units[i]),
                       i == 0 ? std::nullopt : std::optional<double>(0.0)});
  }
  return Declare<TrajectorySource>("source.trajectory", "Moves the hand's target along way-points, with tremor.")
      .details(
          "Between way-points the target moves from rest to rest with minimum jerk (Flash and Hogan 1985), at constant "
          "speed, or along a natural cubic spline. It rests before the first and after the last way-point. If "
          "`repeat_after` is set, it goes through all of them again; the tremor is not repeated. Rotations are given "
          "as rotation vectors, and left out if the tool cannot rotate. Tremor is a sum of sinusoids whose frequencies "
          "and phases follow from the seed, so the motion is the same function of time at any rate.")
      .hand_path(hand_path)
      .output("target", &TrajectorySource::target, "the target pose of the hand, valid at the time of the step")
      .haptic_rate(&Params::rate, {.doc = "targets per second", .in_reference = 10000})
      .table("points", &Params::points, columns, false, "way-points; rx ry rz is a rotation vector")
      .file("file", &Params::file, false,
            "way-points from comma-separated values with columns such as t_s, x_mm, rx [rad]; instead of points")
      .choice("interpolation", &Params::interpolation,
              {{"minimum_jerk", PathKind::minimum_jerk}, {"linear", PathKind::linear}, {"cubic", PathKind::cubic}},
              std::optional(PathKind::minimum_jerk), "how the target moves between way-points")
      .real("repeat_after", &Params::repeat_after,
            {.doc = "time after which the path begins again, not before its last way-point; 0: never",
             .unit = "s",
             .default_value = 0,
             .min = 0})
      .real("halt", &Params::halt,
            {.doc = "time at which the target stops where it is, without tremor, to show whether a tool comes to rest; "
                    "0: never",
             .unit = "s",
             .default_value = 0,
             .min = 0})
      .real("tremor_amplitude", &Params::tremor_amplitude,
            {.doc = "root mean square of the tremor on each axis; 0 for none",
             .unit = "m",
             .default_value = 0,
             .min = 0,
             .max = 0.01})
      .real("tremor_low", &Params::tremor_low,
            {.doc = "lower end of the tremor's band", .unit = "Hz", .default_value = 8, .min = 0, .max = 500})
      .real("tremor_high", &Params::tremor_high,
            {.doc = "upper end of the tremor's band", .unit = "Hz", .default_value = 12, .min = 0, .max = 500})
      .integer("tremor_components", &Params::tremor_components,
               {.doc = "sinusoids on each axis", .default_value = 16, .min = 1, .max = 256})
      .role(Role::source)
      .info();
}

Target TrajectorySource::at(double t) const {
  const bool halted = halt_ && t >= *halt_;
  const double then = halted ? *halt_ : t;
  const double passes = repeat_after_ > 0 ? std::floor(then / repeat_after_) : 0;
  const double late = std::max(0.0, passes - passes_beside) * repeat_after_;
  Target result = path_.at(then - late, rotates_);
  const Tremor::Value shake = tremor_.at(then);
  result.X_WH.p += shake.p;
  result.V_WH.v += shake.v;
  if (halted) result.V_WH = {};
  return result;
}

void TrajectorySource::step(StepContext& context) {
  target.send(context.now(), at(context.now().seconds()));
}

}  // namespace tactor
