// Numbers as text, without regard to the locale, round-tripping exactly.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ballservo {

/// The text without the blanks around it.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r\n");

/// The whole of `text` (surrounding blanks apart) as a finite decimal number; nothing otherwise (NaN, inf,
/// hex, "1,5").
std::optional<double> parse_number(std::string_view text);

/// The whole of `text` as a decimal integer (no octal, no hex, no fraction); nothing otherwise.
std::optional<long long> parse_integer(std::string_view text);

/// The shortest text that reads back as the same double; empty for a number that is not finite (an unknown
/// cell).
std::string number_text(double value);

/// Names in the order a person expects: "left2.jpg" before "left10.jpg".
bool natural_less(std::string_view a, std::string_view b);

}  // namespace ballservo
