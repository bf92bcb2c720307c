/* Standard output that is a terminal. */
#pragma once

/* From here on control characters but new lines and tabs reach it as '?': files name surfaces,
 * columns and other files. What goes elsewhere is left as it is. */
void cli_guard_terminal(void);
