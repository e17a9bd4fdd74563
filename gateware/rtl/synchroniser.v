// Brings an input that knows nothing of our clock into it, two clocks later. `AFTER_RESET` is what the input is taken for at first.
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
