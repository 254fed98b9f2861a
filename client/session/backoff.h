// How long to wait before trying again, with a random part: those who were sent away together are
// not to come back together.
#pragma once

namespace penumbra {

// Between half of `seconds` and all of it; where nobody has said how long.
double Jittered(double seconds);

// Between `seconds` and one and a half times as long; where a server has asked for `seconds`.
double JitteredAfter(double seconds);

}  // namespace penumbra
