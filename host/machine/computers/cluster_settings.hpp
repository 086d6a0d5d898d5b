// The keys of a topology about computers: their values and limits.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/machine/topology.hpp"

namespace pxpl5::host {

inline constexpr int max_computers = 256;

/// The words of a list with commas.
std::vector<std::string> words_of(std::string_view text);

/// Sets address and port where computers join, by "10.0.0.1", "10.0.0.1:5755" or ":5755". Throws
/// RequestError (usage) for a port out of range. check_cluster() checks the address.
void set_listen(ClusterSettings& cluster, std::string_view text);

/// The text that set_listen() reads.
std::string listen_text(const ClusterSettings& cluster);

/// Sets one value. Returns false if `key` is not about computers. Throws RequestError (usage).
bool set_cluster_value(ClusterSettings& cluster, std::string_view key, std::string_view value);

/// Returns why `name` cannot be the name of a computer, which becomes an argument of other programs
/// and a part of file names; empty if it can be.
std::string problem_of_name(std::string_view name);

/// Checks the names of computers in `key`. Throws RequestError (usage).
///
/// where  Begins the text of the error.
void check_names(const std::vector<std::string>& names, const std::string& where,
                 std::string_view key);

/// Checks the ranges of all values. Throws RequestError (usage) as check_names() does.
void check_cluster(const ClusterSettings& cluster, const std::string& where);

/// Throws RequestError (usage) unless `text` is an IPv4 address.
void check_ipv4(const std::string& what, const std::string& text);

/// Throws RequestError (usage) if the plan of `file`, which may come from a stranger, uses an
/// engine and `overrides` do not name it.
void check_trust(const ClusterSettings& cluster, const std::string& file,
                 const std::vector<std::string>& overrides);

}  // namespace pxpl5::host
