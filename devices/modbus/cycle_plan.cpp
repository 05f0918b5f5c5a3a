#include "devices/modbus/cycle_plan.hpp"

#include <algorithm>
#include <numeric>
#include <set>

#include "framework/core/check.hpp"

namespace tactor::modbus {

namespace {

constexpr int most_read = 125;     // words an answer may hold
constexpr int most_written = 121;  // words that function 23 may write

std::vector<std::size_t> by_address(const Profile& profile, const std::set<std::size_t>& registers) {
  std::vector<std::size_t> list(registers.begin(), registers.end());
  std::sort(list.begin(), list.end(),
            [&](std::size_t a, std::size_t b) { return profile.registers[a].address < profile.registers[b].address; });
  return list;
}

std::vector<Transaction> reads(const Profile& profile, const std::set<std::size_t>& registers) {
  std::vector<Transaction> result;
  for (const int function : {3, 4}) {
    bool any = false;
    for (const std::size_t r : by_address(profile, registers)) {
      const RegisterInfo& info = profile.registers[r];
      if (info.read_function != function) continue;
      const int end = info.address + info.width();
      if (any) {
        Transaction& last = result.back();
        const int last_end = last.read_address + last.read_count;
        if (info.address - last_end <= profile.read_gap && end - last.read_address <= most_read) {
          last.read_count = std::max(last.read_count, end - last.read_address);
          continue;
        }
      }
      result.push_back({.function = function, .read_address = info.address, .read_count = info.width()});
      any = true;
    }
  }
  return result;
}

/// By the function that each register declares, in the order of their addresses. Function 6 takes one word at a time.
std::vector<Transaction> writes(const Profile& profile, const std::vector<std::size_t>& registers) {
  std::vector<Transaction> result;
  for (const std::size_t r : by_address(profile, {registers.begin(), registers.end()})) {
    const RegisterInfo& info = profile.registers[r];
    const int end = info.address + info.width();
    if (!result.empty() && result.back().function == info.write_function) {
      Transaction& last = result.back();
      const int last_end = last.write_address + last.write_count;
      const int furthest = info.write_function == 6 ? last_end - 1 : last_end;
      if (info.address <= furthest && end - last.write_address <= most_written) {
        last.write_count = std::max(last.write_count, end - last.write_address);
        continue;
      }
    }
    result.push_back({.function = info.write_function, .write_address = info.address, .write_count = info.width()});
  }
  return result;
}

[[noreturn]] void refuse(const SourceLocation& place, const std::string& message) {
  throw YamlError({{place, message}});
}

/// Joins the one write by function 23 to the first read by function 3.
void combine(const Profile& profile, std::vector<Transaction>& writes, std::vector<Transaction>& reads) {
  const auto by = [](int function) { return [function](const Transaction& t) { return t.function == function; }; };
  const auto blocks = std::count_if(writes.begin(), writes.end(), by(23));
  if (blocks != (profile.combined ? 1 : 0)) {
    refuse(profile.places.cycle, std::string("cycle: expected ") +
                                     (profile.combined ? "one block of words that is written by function 23"
                                                       : "cycle: combined for what is written by function 23") +
                                     ", found " + std::to_string(blocks));
  }
  if (!profile.combined) return;
  const auto write = std::find_if(writes.begin(), writes.end(), by(23));
  const auto read = std::find_if(reads.begin(), reads.end(), by(3));
  if (read == reads.end())
    refuse(profile.places.cycle, "cycle: expected a register that is read by function 3 to combine, found none");
  read->function = 23;
  read->write_address = write->write_address;
  read->write_count = write->write_count;
  writes.erase(write);
}

bool is_like(const Fence& fence, const Transaction& transaction) {
  return transaction.function == fence.function && transaction.read_count == fence.count;
}

/// All reads that are ever asked for: those of the cycle, and of single registers.
std::vector<Transaction> all_reads(const Profile& profile, const CyclePlan& plan) {
  std::vector<Transaction> all = plan.each;
  all.insert(all.end(), plan.seldom.begin(), plan.seldom.end());
  const auto add = [&](std::size_t index) {
    const RegisterInfo& info = profile.registers[index];
    all.push_back({.function = info.read_function, .read_address = info.address, .read_count = info.width()});
  };
  for (const Expectation& e : profile.identify) add(e.index);
  for (const auto* steps : {&profile.start_up, &profile.shut_down, &profile.calibrate}) {
    for (const Step& step : *steps) {
      if (step.kind == Step::Kind::expect) add(step.index);
    }
  }
  return all;
}

/// Reads from the beginning of a register to the end of another one, with gaps of up to so many words between.
std::vector<Fence> spans(const Profile& profile, int gap) {
  std::vector<Fence> result;
  for (const int function : {3, 4}) {
    std::set<std::size_t> readable;
    for (std::size_t i = 0; i < profile.registers.size(); ++i) {
      const RegisterInfo& info = profile.registers[i];
      if (info.readable && info.read_function == function) readable.insert(i);
    }
    const std::vector<std::size_t> list = by_address(profile, readable);
    for (std::size_t first = 0; first < list.size(); ++first) {
      const int begin = profile.registers[list[first]].address;
      int end = begin;
      for (std::size_t i = first; i < list.size(); ++i) {
        const RegisterInfo& info = profile.registers[list[i]];
        end = std::max(end, info.address + info.width());
        if (end - begin > most_read) break;
        result.push_back({function, begin, end - begin});
        if (i + 1 < list.size() && profile.registers[list[i + 1]].address - end > gap) break;
      }
    }
  }
  return result;
}

Fence choose_fence(const Profile& profile, const CyclePlan& plan) {
  const std::vector<Transaction> all = all_reads(profile, plan);
  const auto taken = [&](const Fence& fence) {
    return std::any_of(all.begin(), all.end(), [&](const Transaction& t) { return is_like(fence, t); });
  };
  const std::string why =
      "a fence, a read that no read of the cycle, of identify or of a sequence looks like (function and count), which "
      "tells late answers on a serial line from new ones";
  if (profile.fence) {
    if (!taken(*profile.fence)) return *profile.fence;
    refuse(profile.places.fence, "fence: expected " + why + ", found function " +
                                     std::to_string(profile.fence->function) + " and count " +
                                     std::to_string(profile.fence->count) + ", which one of them has");
  }
  // The surest to be answered first: registers that the device has, then parts of them, then words between them.
  std::vector<Fence> candidates = spans(profile, 0);
  for (const Transaction& t : all) {
    // Function 23 answers as itself, so that function 3 is always free beside it.
    for (int count = t.read_count; count >= 1; --count) {
      candidates.push_back({t.function == 4 ? 4 : 3, t.read_address, count});
    }
  }
  const std::vector<Fence> with_gaps = spans(profile, profile.read_gap);
  candidates.insert(candidates.end(), with_gaps.begin(), with_gaps.end());
  for (const Fence& fence : candidates) {
    if (!taken(fence)) return fence;
  }
  refuse(profile.places.file, "expected the key fence with " + why + ", found none, and no read fits automatically");
}

}  // namespace

std::vector<std::size_t> Profile::written_each_cycle() const {
  std::set<std::size_t> written;
  for (const Axis& axis : axes) {
    written.insert(axis.effort);
    if (axis.sign) written.insert(*axis.sign);
  }
  for (const auto* values : {&each_cycle, &at_zero}) {
    for (const auto& [index, value] : *values) written.insert(index);
  }
  return {written.begin(), written.end()};
}

Duration LineSettings::silent() const {
  if (silence) return *silence;
  const Duration most_of_a_character{3 * character().ns + character().ns / 2};
  return baud > 19200 ? Duration{1'750'000} : most_of_a_character;
}

CyclePlan plan_cycle(const Profile& profile) {
  std::set<std::size_t> read, seldom;
  for (const Axis& axis : profile.axes) read.insert(axis.position);
  for (const Button& button : profile.buttons) read.insert(button.index);
  CyclePlan plan;
  for (const Status& status : profile.status) {
    (status.every == 1 ? read : seldom).insert(status.index);
    if (status.every > 1)
      plan.seldom_every = plan.seldom_every == 1 ? status.every : std::min(plan.seldom_every, status.every);
  }
  std::vector<Transaction> first = writes(profile, profile.written_each_cycle()), then = reads(profile, read);
  combine(profile, first, then);
  plan.each = std::move(first);
  plan.each.insert(plan.each.end(), then.begin(), then.end());
  plan.seldom = reads(profile, seldom);
  // In turn: each comes as often as it asks.
  if (!plan.seldom.empty()) {
    plan.seldom_every = std::max(1, plan.seldom_every / static_cast<int>(plan.seldom.size()));
  }
  plan.fence = choose_fence(profile, plan);
  plan.longest_answer = std::max(plan.longest_answer, 5 + 2 * plan.fence.count);
  for (const auto* list : {&plan.each, &plan.seldom}) {
    for (const Transaction& t : *list) plan.longest_answer = std::max(plan.longest_answer, 5 + 2 * t.read_count);
  }
  return plan;
}

double seconds_of(const Transaction& t, const LineSettings& line, bool serial) {
  if (!serial) return line.turnaround.seconds();
  int request = 0, answer = 0;  // characters, address and check sum included
  switch (t.function) {
    case 6:
      request = answer = 8;
      break;
    case 16:
      request = 9 + 2 * t.write_count;
      answer = 8;
      break;
    case 23:
      request = 13 + 2 * t.write_count;
      answer = 5 + 2 * t.read_count;
      break;
    default:
      request = 8;
      answer = 5 + 2 * t.read_count;
  }
  return (request + answer) * line.character().seconds() + 2 * line.silent().seconds() + line.turnaround.seconds();
}

LineRate line_rate(const CyclePlan& plan, const LineSettings& line, bool serial) {
  LineRate result;
  for (const Transaction& t : plan.each) result.cycle_s += seconds_of(t, line, serial);
  double longest = 0;
  for (const Transaction& t : plan.seldom) longest = std::max(longest, seconds_of(t, line, serial));
  result.cycle_s += longest;
  result.rate = result.cycle_s > 0 ? std::min(1 / result.cycle_s, line.rate_max) : line.rate_max;
  return result;
}

}  // namespace tactor::modbus
