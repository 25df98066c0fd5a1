// All lens models: a new one is a file of its own, a name in LensModel and a line here.
#pragma once

#include <tuple>
#include <utility>

#include "calibration/camera/camera.hpp"
#include "calibration/camera/lens/brown_lens.hpp"
#include "calibration/camera/lens/kannala_brandt_lens.hpp"
#include "calibration/camera/lens/pinhole_lens.hpp"
#include "calibration/camera/lens/visp_lens.hpp"

namespace ballservo {

/// In the order of LensModel.
using LensList = std::tuple<PinholeLens, VispLens, BrownLens, Brown8Lens, KannalaBrandtLens>;
static_assert(std::tuple_size_v<LensList> == all_lens_models.size());

template <class Lens>
inline constexpr int lens_coefficient_count = static_cast<int>(Lens::coefficient_names.size());

/// Calls `visit` with the lens struct of a model.
template <class Visitor, std::size_t index = 0>
decltype(auto) with_lens(LensModel model, Visitor&& visit) {
  if constexpr (index + 1 < std::tuple_size_v<LensList>) {
    if (static_cast<std::size_t>(model) != index)
      return with_lens<Visitor, index + 1>(model, std::forward<Visitor>(visit));
  }
  return visit(std::tuple_element_t<index, LensList>{});
}

}  // namespace ballservo
