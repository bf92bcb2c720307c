/* Student's t. */
#pragma once

/* The two-sided 95 % point, within 0.1 % at whole degrees of freedom; below 1 that of 1. */
double hetab_student_95(double freedom);
