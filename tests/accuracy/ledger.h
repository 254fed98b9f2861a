// What was measured of accuracy, kept in a file, so that a change for the worse is seen.
//
//   ExpectInLedger("radiance.disk.relative_error", worst);
#pragma once

#include <string_view>

namespace penumbra::testing {

// Fails if `metric` has no line in ledger.txt, if `measured` is more than a quarter above the value
// kept there, or above the bar. What got much better is said, so that the line can be tightened.
void ExpectInLedger(std::string_view metric, double measured);

}  // namespace penumbra::testing
