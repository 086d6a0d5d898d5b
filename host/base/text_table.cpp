#include "host/base/text_table.hpp"

#include <algorithm>
#include <cassert>

namespace pxpl5::host {

namespace {

std::string line_of(const TableRow& row, const std::vector<std::size_t>& widths, std::size_t left) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
        const std::string blanks(widths[i] - row[i].size(), ' ');
        line += (i == 0 ? "" : "  ") + (i < left ? row[i] + blanks : blanks + row[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    return line + "\n";
}

}  // namespace

std::string text_table(const TableRow& heading, const std::vector<TableRow>& rows,
                       std::size_t left) {
    std::vector<std::size_t> widths;
    for (std::size_t i = 0; i < heading.size(); ++i) {
        widths.push_back(heading[i].size());
        for (const TableRow& row : rows) {
            assert(row.size() == heading.size());
            widths[i] = std::max(widths[i], row[i].size());
        }
    }
    std::string text = line_of(heading, widths, left);
    for (const TableRow& row : rows) {
        text += line_of(row, widths, left);
    }
    return text;
}

}  // namespace pxpl5::host
