/* Lines and fields of a measurement file's text, cut off in place. */
#ifndef HETAB_MEASURED_MEASUREMENT_TEXT_H
#define HETAB_MEASURED_MEASUREMENT_TEXT_H

#include <stddef.h>

/* The next line, without blanks and '\r' around it; NULL at the end of *text. Counts *line. */
char *hetab_cut_line(char **text, size_t *line);
/* The next line that is not empty after the comment ('#' to its end) is cut off. */
char *hetab_cut_content(char **text, size_t *line);
/* The next field, without blanks around it; *line becomes NULL after the last. */
char *hetab_cut_field(char **line, char separator);
/* How many fields there are. */
size_t hetab_count_fields(const char *line, char separator);

#endif
