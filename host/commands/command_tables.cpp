// The one table of commands. Each row is data: what the command takes, and the function to run.
#include "host/commands/command_tables.hpp"

namespace pxpl5::host {

CommandTable command_table() {
    static const std::vector<Command> table = [] {
        std::vector<Command> rows;
        for (const auto& group :
             {volume_commands(), series_commands(), slice_commands(), surface_commands(),
              mesh_commands(), view_commands(), style_commands(), drawing_commands(),
              pixel_commands(), picture_commands(), machine_commands(), session_commands()}) {
            rows.insert(rows.end(), group.begin(), group.end());
        }
        return rows;
    }();
    return table;
}

}  // namespace pxpl5::host
