#include "servo/features/builtin_laws.hpp"

#include "servo/features/cone_law.hpp"
#include "servo/features/pose_law.hpp"
#include "servo/features/sphere_law.hpp"
#include "servo/features/visp_law.hpp"

namespace ballservo {

namespace {
template <typename TheLaw>
std::unique_ptr<Law> of(const LawOptions& options, const ServoGoal& goal) {
  return std::make_unique<TheLaw>(options, goal);
}
}  // namespace

LawCatalog builtin_laws() {
  LawCatalog laws;
  laws.add("cone", of<ConeLaw>);
  laws.add("visp", of<VispLaw>);
  laws.add("sphere", of<SphereLaw>);
  laws.add("pose", of<PoseLaw>);
  return laws;
}

}  // namespace ballservo
