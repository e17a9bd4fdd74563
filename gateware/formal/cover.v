// A cover as an assertion that it never holds: refuting it shows that it can.
module \$cover (A, EN);
    input A, EN;
    \$assert _TECHMAP_REPLACE_ (.A(!A), .EN(EN));
endmodule
