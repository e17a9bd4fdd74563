// Messages of failed checks, and the last line that `run` looks for.
`define CHECK(what, is, expected) \
    if ((is) !== (expected)) begin \
        $display("%m at %0t: %0s is %0d instead of %0d", $time, what, is, expected); \
        errors = errors + 1; \
    end
`define END if (errors == 0) $display("ok"); $finish;
