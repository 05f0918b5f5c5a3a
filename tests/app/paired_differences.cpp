// What the statistics of studies make of pairs of groups, for a test that has scipy compute the same. Each line of
// standard input holds a group and, after a bar, the other; each line of standard output an object of JSON.
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "app/statistics.hpp"

namespace {

std::vector<double> numbers(const std::string& text) {
  std::istringstream in(text);
  std::vector<double> values;
  for (double v = 0; in >> v;) values.push_back(v);
  return values;
}

nlohmann::json number(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

}  // namespace

int main() {
  for (std::string line; std::getline(std::cin, line);) {
    const std::size_t bar = line.find('|');
    const std::vector<double> a = numbers(line.substr(0, bar)), b = numbers(line.substr(bar + 1));
    nlohmann::json found;
    if (const auto paired = tactor::paired_difference(a, b)) {
      found["mean"] = paired->mean;
      found["identical"] = paired->identical != tactor::Identical::no;
      found["interval"] = nlohmann::json::array();
      if (paired->interval) found["interval"] = {paired->interval->low, paired->interval->high};
      found["effect_size"] = number(paired->effect_size);
      found["p_wilcoxon"] = number(paired->p_wilcoxon);
    }
    if (const auto anova = tactor::one_way_anova(a, b)) found["anova"] = {anova->F, anova->p};
    std::cout << found << "\n";
  }
  return 0;
}
