// What every bench has in its module: a clock and a count of what was wrong.
integer errors = 0;
reg clk = 0;
always #5 clk = !clk;
