// The peer: a plain gRPC echo under the same number of messages, of clients and of bytes.
#pragma once

#include <vector>

namespace penumbra::load {

// From when each message was due until it was back, milliseconds.
std::vector<double> EchoLoad(int clients, double rate, double seconds);

}  // namespace penumbra::load
