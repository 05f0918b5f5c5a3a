// Answers of a Modbus device to one of our requests. The first bytes choose the request, the others are what comes
// back. What is believed is an answer that repeats the request; what is read never reaches beyond the frame.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "devices/modbus/frame.hpp"
#include "require.hpp"

namespace {

using namespace tactor;
using namespace tactor::modbus;
using fuzz::require;

void believed(std::span<const std::uint8_t> answer, const Transaction& t, std::span<const std::uint8_t> sent,
              const Framing& framing) {
  const std::size_t head = framing.serial ? 1 : 7;
  require(answer[head - 1] == framing.unit && answer[head] == t.function, "unit and function are those asked for");
  if (!framing.serial) {
    require(std::equal(answer.begin(), answer.begin() + 4, sent.begin()), "transaction and protocol are repeated");
    require(static_cast<std::size_t>(answer[4] << 8 | answer[5]) == answer.size() - 6, "the header has its length");
  }
  if (t.read_count > 0) {
    require(answer.size() == head + 2 + 2 * static_cast<std::size_t>(t.read_count) + (framing.serial ? 2 : 0),
            "it has the words asked for");
    std::vector<std::uint16_t> words(static_cast<std::size_t>(t.read_count));
    take_words(answer, t, framing, words.data());
  } else {
    require(std::equal(answer.begin() + static_cast<std::ptrdiff_t>(head) + 1,
                       answer.begin() + static_cast<std::ptrdiff_t>(head) + 5,
                       sent.begin() + static_cast<std::ptrdiff_t>(head) + 1),
            "a write is repeated");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 4) return 0;
  constexpr std::array functions{3, 4, 6, 16, 23};
  Transaction t{.function = functions[data[0] % functions.size()]};
  const bool writes = t.function == 6 || t.function == 16 || t.function == 23;
  if (t.function != 6 && t.function != 16) {
    t.read_address = data[2];
    t.read_count = 1 + data[1] % 125;
  }
  if (writes) {
    t.write_address = data[2];
    t.write_count = t.function == 6 ? 1 : 1 + data[1] % 121;
  }
  const std::vector<std::uint16_t> words(125, 0x0102);
  const Framing framing{(data[3] & 1U) != 0, 1 + (data[3] >> 1) % 247, data[2] << 8 | data[1]};
  std::vector<std::uint8_t> sent;
  put_request(t, words.data(), framing, sent);
  const std::span<const std::uint8_t> line(data + 4, size - 4);
  // As the client reads: no more than is missing.
  std::vector<std::uint8_t> come;
  for (;;) {
    const AnswerState state = judge_answer(come, t, sent, framing);
    if (state.kind == AnswerState::Kind::good) believed(come, t, sent, framing);
    if (state.kind == AnswerState::Kind::wrong) {
      require(!state.text.empty() && state.error != LinkError::none, "a refusal says why");
    }
    if (state.kind != AnswerState::Kind::incomplete) break;
    require(state.missing > 0 && come.size() + state.missing <= longest_frame, "no more than a frame is read");
    if (come.size() + state.missing > line.size()) break;
    come.insert(come.end(), line.begin() + static_cast<std::ptrdiff_t>(come.size()),
                line.begin() + static_cast<std::ptrdiff_t>(come.size() + state.missing));
  }
  return 0;
}
