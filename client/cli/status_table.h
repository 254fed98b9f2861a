// What goes on at a server as a table for people.
//
//   out << StatusTable("127.0.0.1:7717", &before, now, 20);
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace penumbra {

// `before`, `now`  answers of GetServerStatus in protobuf's JSON, one after the other; rates are
//                  what has come in between. null: there is none before, and no rates are shown
// `max_rows`       of scenes, those with most edits, and of clients, those that are sent most
std::string StatusTable(const std::string& address, const nlohmann::ordered_json* before,
                        const nlohmann::ordered_json& now, size_t max_rows);

// "3 sessions, 12 subscriptions, …", of a ServerStatistics.
std::string CountersText(const nlohmann::ordered_json& statistics);

// "2 d 03:04:05", or without the days.
std::string DurationText(double seconds);

// "12.3 MB".
std::string BytesText(double bytes);

// `text` as it may be shown on a terminal, in exactly `columns` characters: what could move the
// cursor, turn the direction of writing round or is no UTF-8 is shown as '?', and what is too long
// ends in "…". Wide characters are not counted as such.
std::string CellText(std::string_view text, size_t columns);

}  // namespace penumbra
