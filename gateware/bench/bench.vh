// Common declarations of all benches: a clock and an error count.
integer errors = 0;
reg clk = 0;
always #5 clk = !clk;
