// Circles by algebra, without a start: the two that everybody knows.
//
// With z = x^2 + y^2 a circle is A z + B x + C y + D = 0 and each point leaves an algebraic distance P. Kasa
// (IEEE Trans. Instrum. Meas. 25, 1976) minimises sum w P^2 with A = 1; since P is about (2 r) times the
// geometric distance d, a smaller circle is cheaper, and short arcs give circles that are too small. Taubin
// (IEEE PAMI 13, 1991) minimises sum w P^2 / sum w |grad P|^2, which takes most of that away.
#pragma once

#include <optional>
#include <vector>

#include "perception/outline/paper_refinement.hpp"

namespace ballservo {

/// Nothing for fewer than 3 pixels of weight, values that are not finite, or pixels on a line.
std::optional<UndistortedCircle> kasa_circle(const std::vector<RingPixel>& points);
std::optional<UndistortedCircle> taubin_circle(const std::vector<RingPixel>& points);

}  // namespace ballservo
