#include "nodes/physics/contact/doubts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace tactor {

namespace {

constexpr double far_away = 100;     // lengths of the longest body
constexpr double shallow = 1.0 / 3;  // of the shortest side

std::string length(double metres) {
  std::array<char, 40> text{};
  const double size = std::abs(metres);
  if (size < 1) {
    std::snprintf(text.data(), text.size(), "%.3g mm", 1e3 * metres);
  } else {
    std::snprintf(text.data(), text.size(), "%.3g m", metres);
  }
  return text.data();
}

/// To two digits: a tremor's seed is not told of as something else.
std::string about(double metres) {
  if (metres == 0) return length(0);
  const double digit = std::pow(10, std::floor(std::log10(std::abs(metres))) - 1);
  return length(digit * std::round(metres / digit));
}

double shortest(const Bounds& box) {
  const Vec3 size = box.size();
  return std::min({size.x, size.y, size.z});
}

bool is_finite(const Bounds& box) {
  return std::isfinite(box.longest());
}

/// m, of a point from a box; 0 inside.
double distance_from(const Bounds& box, const Vec3& p) {
  Vec3 out;
  for (int axis = 0; axis < 3; ++axis) out[axis] = std::max({box.low[axis] - p[axis], 0.0, p[axis] - box.high[axis]});
  return norm(out);
}

/// The box along the world's axes about that of a body.
Bounds in_world(const ContactBody& body, const Pose& X_WB) {
  Bounds bounds;
  for (int c = 0; c < 8; ++c) {
    const Bounds& own = body.box;
    bounds.add(transform(X_WB, {(c & 1) != 0 ? own.high.x : own.low.x, (c & 2) != 0 ? own.high.y : own.low.y,
                                (c & 4) != 0 ? own.high.z : own.low.z}));
  }
  return bounds;
}

/// The largest distance of a point of the body from its origin, at most; m.
double reach_of(const ContactBody& body) {
  return norm(body.p_BM) + body.radius;
}

/// How near the tool comes to the body on the way, at least; m, not above zero where they may meet.
double least_gap(const ContactBody& tool, const ContactBody& body, const HandPath& hand) {
  const Pose X_BW = inverse(body.X_WB);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hand.X_WH.size(); ++i) {
    const Vec3& p_WH = hand.X_WH[i].p;
    const double step = i > 0 ? norm(p_WH - hand.X_WH[i - 1].p) : 0;
    least = std::min(least, distance_from(body.box, transform(X_BW, p_WH)) - step);
  }
  return least - reach_of(tool);
}

}  // namespace

std::vector<std::string> doubts_of_spacing(std::span<const ContactBody> bodies, const std::vector<bool>& sampled,
                                           double spacing) {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto* capsule = std::get_if<CapsuleShape>(&bodies[i].shape);
    const double longest = bodies[i].box.longest();
    const double usual = capsule != nullptr ? capsule->radius : longest / 4;
    // The slack is that of a decimal number.
    if (!sampled[i] || !(spacing > usual * (1 + 1e-9))) continue;
    notes.push_back("body '" + bodies[i].name + "': warning: a spacing of contact samples of " + length(spacing) +
                    " is large for a body that is " + length(longest) +
                    " long: it may go that deep into another body before a contact is found; give at most " +
                    length(usual) + ", or 0, which chooses by the body");
  }
  return notes;
}

std::vector<std::string> doubts_of_path(std::span<const ContactBody> bodies, const HandPath& hand) {
  std::vector<std::string> notes;
  const ContactBody& tool = bodies.front();
  const bool alone =
      std::count_if(bodies.begin(), bodies.end(), [](const ContactBody& b) { return b.motion != Motion::fixed; }) == 1;
  double gap = std::numeric_limits<double>::infinity();
  Bounds all = in_world(tool, hand.X_WH.front());
  double longest = tool.box.longest();
  for (const ContactBody& body : bodies.subspan(1)) {
    gap = std::min(gap, least_gap(tool, body, hand));
    if (!is_finite(body.box)) continue;
    const Bounds box = in_world(body, body.X_WB);
    all.add(box.low);
    all.add(box.high);
    longest = std::max(longest, body.box.longest());
  }
  if (alone && bodies.size() > 1 && gap > 0) {
    notes.push_back(
        "warning: the hand does not lead the tool '" + tool.name + "' to any body: it keeps " + about(gap) +
        " away, by their bounding boxes; the tool touches only if gravity or its start pose brings it there");
  }
  double farthest = 0;
  for (const Pose& X_WH : hand.X_WH) farthest = std::max(farthest, distance_from(all, X_WH.p));
  if (farthest > far_away * longest) {
    notes.push_back("warning: the hand's path leaves the scene: it goes " + about(farthest) +
                    " away from all bodies, and the longest of them is " + length(longest) +
                    " long; are the units of the path and of the bodies right?");
  }
  return notes;
}

std::vector<std::string> doubts_of_start(const ContactBody& a, const ContactBody& b, double depth) {
  if (!(depth > shallow * std::min(shortest(a.box), shortest(b.box)))) return {};
  return {"warning: the body '" + a.name + "' starts " + about(depth) + " inside the body '" + b.name +
          "': the contact's spring hits it when the run begins; start it outside"};
}

}  // namespace tactor
