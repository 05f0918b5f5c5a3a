#include "nodes/physics/mesh/mesh_words.hpp"

#include <algorithm>

namespace tactor {

namespace {

constexpr std::string_view blanks = " \t\r\f\v";

}  // namespace

std::string shown_word(std::string_view word) {
  constexpr std::size_t most = 40;
  std::string text(word.substr(0, most));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return "'" + text + (word.size() > most ? "...'" : "'");
}

std::string_view MeshWords::next() {
  for (;;) {
    if (const std::string_view word = next_in_line(); !word.empty()) return word;
    if (at_ >= text_.size()) return {};
    ++at_, ++line_;
  }
}

std::string_view MeshWords::next_in_line() {
  for (;;) {
    take(ReadBudget::step_cost);
    at_ = std::min(text_.find_first_not_of(blanks, at_), text_.size());
    if (at_ == text_.size() || text_[at_] == '\n') return {};
    if (text_[at_] == '#') {
      skip_line();
      return {};
    }
    const std::size_t begin = at_;
    at_ = std::min(text_.find_first_of(" \t\r\f\v\n#", begin), text_.size());
    const std::string_view word = text_.substr(begin, at_ - begin);
    if (word != "\\") return word;
    at_ = std::min(text_.find_first_not_of(blanks, at_), text_.size());
    if (at_ == text_.size() || text_[at_] != '\n') return word;
    ++at_, ++line_;
  }
}

void MeshWords::skip_line() {
  at_ = std::min(text_.find('\n', at_), text_.size());
}

Vec3 MeshWords::point() {
  Vec3 p;
  for (int axis = 0; axis < 3; ++axis) p[axis] = number<double>("a coordinate of a vertex");
  return checked(p);
}

Vec3 MeshWords::point_in_line() {
  Vec3 p;
  for (int axis = 0; axis < 3; ++axis) p[axis] = number<double>(next_in_line(), "a coordinate of a vertex");
  return checked(p);
}

Vec3 MeshWords::checked(const Vec3& point) const {
  if (is_usable(point)) return point;
  fail("finite coordinates below 1e15",
       std::to_string(point.x) + " " + std::to_string(point.y) + " " + std::to_string(point.z));
}

void MeshWords::fail(const std::string& expected, std::string_view found) const {
  const std::string end = at_ >= text_.size() ? "the end of the file" : "the end of the line";
  throw InputError(place() + ": expected " + expected + ", found " + (found.empty() ? end : shown_word(found)) +
                   "; export the mesh again as " + format_);
}

}  // namespace tactor
