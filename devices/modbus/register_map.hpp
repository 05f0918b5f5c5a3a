// What a register of a Modbus device holds, and the way between its 16-bit words and a value in SI units.
#pragma once

#include <cstdint>
#include <string>

#include "framework/yaml/diagnostics.hpp"

namespace tactor::modbus {

enum class RegisterType : std::uint8_t { int16, uint16, int32, uint32, float32 };

/// Which part of a value comes first: of two words, and of the two bytes of a word. Modbus itself sends the high byte
/// of a word first; some devices fill words the other way round.
enum class Order : std::uint8_t { high_first, low_first };

/// One register, or two for 32 bits.
struct RegisterInfo {
  std::string name;
  int address = 0;  ///< counted from 0, as it goes over the line
  RegisterType type = RegisterType::uint16;
  Order words = Order::high_first;
  Order bytes = Order::high_first;
  double scale = 1;        ///< SI units a count
  std::string unit = "1";  ///< the SI unit
  bool readable = false;
  bool writable = false;
  int read_function = 3;    ///< 3 or 4
  int write_function = 16;  ///< 6, 16 or 23
  int low_bit = 0;          ///< of a field inside a 16-bit register
  int bits = 0;             ///< width of that field; 0: all of the register
  SourceLocation place;

  /// Words it takes, 1 or 2.
  [[nodiscard]] int width() const { return type == RegisterType::int16 || type == RegisterType::uint16 ? 1 : 2; }
};

/// The value in SI units; of a float32 that is not finite, not finite.
double decode(const RegisterInfo& info, const std::uint16_t* words);

/// Puts a value (SI) into the words: rounded to the nearest count and clamped to what the register holds, not-a-number
/// as 0. Of a field the other bits of the word stay as they are.
void encode(const RegisterInfo& info, double value, std::uint16_t* words);

/// The names that profiles use.
std::string to_string(RegisterType type);

}  // namespace tactor::modbus
