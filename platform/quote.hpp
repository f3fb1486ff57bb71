// Text from outside, fit for a message on one line: a terminal shows it as it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace polhode::platform {

inline constexpr std::size_t kQuoteMax = 200;    ///< bytes of the outside's text in a message
inline constexpr std::size_t kMessageMax = 700;  ///< of a whole one, with a long path in it

/// Bytes of the whole, printable UTF-8 character at the front; 0 where there is none.
inline std::size_t printable_bytes(std::string_view text) {
  const auto at = [&text](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  if (text.empty()) {
    return 0;
  }
  if (at(0) < 0x80) {
    return at(0) >= 0x20 && at(0) != 0x7F ? 1 : 0;
  }
  const std::size_t bytes = at(0) >= 0xF0 ? 4 : at(0) >= 0xE0 ? 3 : 2;
  if (at(0) < 0xC2 || at(0) > 0xF4 || text.size() < bytes) {
    return 0;
  }
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((at(i) & 0xC0U) != 0x80) {
      return 0;
    }
  }
  const bool longer_than_needed =
      (at(0) == 0xE0 && at(1) < 0xA0) || (at(0) == 0xF0 && at(1) < 0x90);
  const bool beyond = (at(0) == 0xED && at(1) > 0x9F) || (at(0) == 0xF4 && at(1) > 0x8F);
  const bool control = at(0) == 0xC2 && at(1) < 0xA0;
  return longer_than_needed || beyond || control ? 0 : bytes;
}

/// Unprintable bytes become \xNN; the text is cut after `bytes_max`, with "..." in place of the
/// rest.
inline std::string cited(std::string_view text, std::size_t bytes_max = kQuoteMax) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  while (!text.empty()) {
    const std::size_t good = printable_bytes(text);
    std::string next(text.substr(0, good));
    if (good == 0) {
      const auto byte = static_cast<std::uint8_t>(text.front());
      next = {'\\', 'x', kDigits[byte >> 4U], kDigits[byte & 15U]};
    }
    if (out.size() + next.size() > bytes_max) {
      return out + "...";
    }
    out += next;
    text.remove_prefix(good == 0 ? 1 : good);
  }
  return out;
}

/// As a string of JSON. A byte that is not UTF-8 is the surrogate U+DC80 .. U+DCFF, as Python
/// names files, so that a path from there is the path again.
inline std::string json_text(std::string_view text) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string out = "\"";
  while (!text.empty()) {
    const std::size_t good = printable_bytes(text);
    const auto byte = static_cast<std::uint8_t>(text.front());
    if (good == 0) {
      out += byte < 0x80 ? "\\u00" : "\\udc";
      out += {kDigits[byte >> 4U], kDigits[byte & 15U]};
    } else {
      out += byte == '"' || byte == '\\' ? "\\" : "";
      out += text.substr(0, good);
    }
    text.remove_prefix(good == 0 ? 1 : good);
  }
  return out + '"';
}

/// A whole message: as cited(), but cut in the middle, as its end has the allowed values.
inline std::string legible(std::string_view message) {
  constexpr std::size_t kEnd = 200;  // bytes that stay of it
  if (message.size() <= kMessageMax) {
    return cited(message, 4 * kMessageMax);
  }
  return cited(message.substr(0, kMessageMax - kEnd), 4 * kMessageMax) + " ... " +
         cited(message.substr(message.size() - kEnd), 4 * kEnd);
}

}  // namespace polhode::platform
