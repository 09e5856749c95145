"""The appendix' BASIC listing, run as printed, each faulty line with a repair to switch on."""

import math
import re

# As printed; the two halves of a broken line are joined again.
PRINTED = {
    100: "INPUT R,HH,H,F,J:PI=3.141592654:SS=SQR(HH^2+r*r)",
    110: "LPRINT:LPRINT:LPRINT R,HH,H,F",
    120: "S=H*SS/HH:K=(R/HH)^2:PH=2*PI/SS:PF=PH*F",
    130: "FOR I=0 TO 10",
    140: "U=I/J:ND1=SS+(S*COS(PF)-SS)*U:ND2=S*SIN(PF)*U",
    150: "PHI=ATN(ND2/ND1):TH=SS*PHI/R:TTH=TAN(TH):D=HH*TTH+H",
    160: "NN=SQR(ND1^2+ND2^2):M1=H*R/D:M2=H*R*TTH/D:M3=-H*HH*(TTH+1)/D",
    170: "K1=K+1:M12=M1^2+M2^2:A=K1^2*M12:B=-2*K*K1*M1*M12",
    180: "C=K*M1^2*(K*M12-M3^2):DS=B*B-4*A*C:A2=A*A:IF DS<0 THEN STOP",
    190: "DQ=SQR(DS):N1P=(-B+DQ)/A2:N1M=(-B-DQ)/A2:M21=M2/M1",
    200: "N2P=M21*N1P:N2M=M21*N1M:N3P=M3*N1P/(K*(N1P-M1)+N1P)",
    210: "N3M=M3*N1M/(K*(N1M-M1)+N1M):LN=SQR(N1P^2+N2P^2+N3P^2)",
    220: "M=(M1-N1M)^2+(M2-N2M)^2+(M3-N3M)^2:N=(M1-N1P)^2+(M2-N2P)^2+(M3-N3P)^2",
    230: "IF M<N THEN LN=SQR(N1M^2+N2M^2+N3M^2)",
    240: "LPRINT U,180*PHI/PI, LN, NN, NN-LN",
    250: "NEXT I",
}

REPAIRS = {
    100: "INPUT R,HH,H,F,J:PI=3.141592654:SS=SQR(HH^2+R*R)",
    120: "S=H*SS/HH:K=(R/HH)^2:PH=2*PI*R/SS:PF=PH*F",
    130: "FOR I=0 TO J",
    # The half-angle keeps ATN on its branch; TH may pass 90 degrees without a tangent.
    150: "NN=SQR(ND1^2+ND2^2):PHI=2*ATN(ND2/(NN+ND1)):TH=SS*PHI/R:TF=2*PI*F",
    160: "T=HH*SIN(TH)/(HH*SIN(TH)+H*SIN(TF-TH)):M1=R+T*(H*R/HH*COS(TF)-R)"
    ":M2=T*H*R/HH*SIN(TF):M3=T*(HH-H)-HH",
    180: "C=K*M1^2*(K*M12-M3^2):DS=B*B-4*A*C:A2=2*A:IF DS<0 THEN STOP",
}

FUNCTIONS = {"SQR": math.sqrt, "ATN": math.atan, "SIN": math.sin, "COS": math.cos, "TAN": math.tan}


def run(R, HH, H, F, J, *, repaired=(), fold_case=True):
    """Return the rows that the listing prints for its five inputs.

    Parameters
    ----------
    R, HH, H, F, J : float
        Radius and depth of P's circle, depth of Q, fraction of a turn, number of steps.
    repaired : iterable of int
        Line numbers to take from `REPAIRS`.
    fold_case : bool
        Whether r and R are one variable, as in most BASICs.

    Returns
    -------
    rows : list of list of float
        What line 240 prints.
    """
    lines = PRINTED | {number: REPAIRS[number] for number in repaired}
    order = sorted(lines)
    memory = dict(zip(("R", "HH", "H", "F", "J"), (R, HH, H, F, J), strict=True))
    rows, here, loop = [], 0, None

    def value(expression):
        return eval(expression.replace("^", "**"), FUNCTIONS, memory)

    while here < len(order):
        text = lines[order[here]].upper() if fold_case else lines[order[here]]
        for statement in map(str.strip, text.split(":")):
            if condition := re.fullmatch(r"IF (.+) THEN (.+)", statement):
                if not value(condition[1]):
                    break
                statement = condition[2]
            if statement == "STOP":
                return rows
            if statement.startswith("FOR"):
                name, first, last = re.fullmatch(r"FOR (\w+)=(.+) TO (.+)", statement).groups()
                memory[name], loop = value(first), (here, name, last)
            elif statement.startswith("NEXT"):
                start, name, last = loop
                memory[name] += 1
                if memory[name] <= value(last):
                    here = start
            elif statement.startswith("LPRINT U"):
                rows.append([value(column) for column in statement[6:].split(",")])
            elif not statement.startswith(("INPUT", "LPRINT")):
                name, expression = statement.split("=", 1)
                memory[name] = value(expression)
        here += 1
    return rows
