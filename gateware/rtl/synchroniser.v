// Synchronises an asynchronous input to our clock, two clocks later. `AFTER_RESET` is its assumed initial value.
`default_nettype none

module synchroniser #(
    parameter AFTER_RESET = 1'b1
) (
    input  wire clk,
    input  wire reset,
    input  wire from_outside,
    output reg  synchronised
);
    (* ASYNC_REG = "TRUE" *)
    reg caught;

    always @(posedge clk) begin
        if (reset) {synchronised, caught} <= {AFTER_RESET[0], AFTER_RESET[0]};
        else {synchronised, caught} <= {caught, from_outside};
    end
endmodule

`default_nettype wire
