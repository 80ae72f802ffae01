"""One run or thousands, compiled or by NumPy, in the plane or on tyres; search for gains."""
