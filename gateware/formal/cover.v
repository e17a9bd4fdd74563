// A cover as the assertion that it never holds: a counterexample shows that it can.
module \$cover (A, EN);
    input A, EN;
    \$assert _TECHMAP_REPLACE_ (.A(!A), .EN(EN));
endmodule
