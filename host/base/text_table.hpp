// Tables for people: columns as wide as what they hold.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace pxpl5::host {

using TableRow = std::vector<std::string>;

/// Lines end with a newline. The first `left` columns are aligned at the left, the others at the
/// right. All rows have as many cells as the heading.
std::string text_table(const TableRow& heading, const std::vector<TableRow>& rows,
                       std::size_t left = 1);

}  // namespace pxpl5::host
